//! Ascending lists of nodes or cells that change in a few places.

/// Puts numbers that are not there into a list, both in ascending order.
pub(super) fn insert(list: &mut Vec<u32>, new: &[u32]) {
    let mut end = list.len();
    list.resize(end + new.len(), 0);
    for (count, &number) in new.iter().enumerate().rev() {
        let place = list[..end].partition_point(|&known| known < number);
        list.copy_within(place..end, place + count + 1);
        list[place + count] = number;
        end = place;
    }
}

/// Takes numbers that are there out of a list, both in ascending order.
pub(super) fn remove(list: &mut Vec<u32>, gone: &[u32]) {
    let mut next = list.partition_point(|&known| gone.first().is_some_and(|&number| known < number));
    for (count, _) in gone.iter().enumerate() {
        let place = next;
        next = gone.get(count + 1).map_or(list.len(), |&number| list.partition_point(|&known| known < number));
        list.copy_within(place + 1..next, place - count);
    }
    list.truncate(list.len() - gone.len());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_and_go() {
        let mut list: Vec<u32> = vec![2, 3, 5, 7, 11];
        insert(&mut list, &[0, 1, 4, 6, 12]);
        assert_eq!(list, [0, 1, 2, 3, 4, 5, 6, 7, 11, 12]);
        remove(&mut list, &[0, 2, 3, 6, 12]);
        assert_eq!(list, [1, 4, 5, 7, 11]);
        insert(&mut list, &[]);
        remove(&mut list, &[]);
        remove(&mut list, &[1, 4, 5, 7, 11]);
        assert!(list.is_empty());
        insert(&mut list, &[8]);
        assert_eq!(list, [8]);
    }
}
