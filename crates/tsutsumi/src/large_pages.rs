//! Large arrays in large pages of memory, where the system has them.
//!
//! A processor looks up where each page of memory is, and remembers some thousand of them: with pages of 4 kB, as usual, that is less than a large body
//! has, and what a pass asks for ahead comes late. Linux gives pages of 2 MB to those who ask; numpy does, so that programs in Python have them.

use std::mem::MaybeUninit;

/// Arrays of fewer bytes stay in the pages they have.
const LEAST_BYTES: usize = 1 << 22;

/// An array of the same value throughout.
pub(crate) fn filled<T: Copy>(value: T, len: usize) -> Vec<T> {
    let mut values = Vec::with_capacity(len);
    ask(values.spare_capacity_mut());
    values.resize(len, value);
    values
}

/// Moves an array that has been written already to large pages.
pub(crate) fn settle<T: Copy>(values: &mut Vec<T>) {
    if size_of_val(&values[..]) < LEAST_BYTES {
        return;
    }
    let mut settled = Vec::with_capacity(values.len());
    ask(settled.spare_capacity_mut());
    settled.extend_from_slice(values);
    *values = settled;
}

/// Asks for large pages where nothing has been written yet. The system may refuse: nothing is lost but time.
#[cfg(target_os = "linux")]
#[allow(unsafe_code, reason = "only the system knows how memory is backed, and can only be asked by address")]
fn ask<T>(memory: &mut [MaybeUninit<T>]) {
    /// The smallest pages of all machines: addresses have to be at the start of one.
    const PAGE: usize = 1 << 12;
    let bytes = size_of_val(memory);
    if bytes < LEAST_BYTES {
        return;
    }
    let start = memory.as_mut_ptr().cast::<u8>();
    let before = start.addr() % PAGE;
    // SAFETY: advice on how memory is backed changes nothing that stands in it, on the pages of this array or on what shares the first with it.
    unsafe { libc::madvise(start.wrapping_sub(before).cast(), before + bytes, libc::MADV_HUGEPAGE) };
}

/// Elsewhere nobody can be asked.
#[cfg(not(target_os = "linux"))]
fn ask<T>(_memory: &mut [MaybeUninit<T>]) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_stay_what_they_are() {
        for len in [10, 1_000_000] {
            let mut values: Vec<f64> = (0..len).map(f64::from).collect();
            values.reserve(7);
            settle(&mut values);
            assert!(values.iter().copied().eq((0..len).map(f64::from)));
            assert_eq!(filled(2.5, len as usize), vec![2.5; len as usize]);
        }
    }

    /// What the system says of the memory of an array: it has to be told apart from others that were not asked for.
    #[cfg(target_os = "linux")]
    #[test]
    fn the_system_has_been_asked() {
        let values = filled(1_u64, 10 * LEAST_BYTES / 8);
        let address = values[values.len() / 2..].as_ptr().addr();
        let maps = std::fs::read_to_string("/proc/self/smaps").unwrap();
        let mut is_here = false;
        let mut flags = None;
        for line in maps.lines() {
            let range = line.split(' ').next().and_then(|range| range.split_once('-'));
            let ends =
                range.and_then(|(a, b)| Some((usize::from_str_radix(a, 16).ok()?, usize::from_str_radix(b, 16).ok()?)));
            if let Some((start, end)) = ends {
                is_here = (start..end).contains(&address);
            } else if is_here && line.starts_with("VmFlags:") {
                flags = Some(line.to_owned());
            }
        }
        // A kernel without large pages has no such flag to set.
        let has_large_pages = std::path::Path::new("/sys/kernel/mm/transparent_hugepage").exists();
        assert!(!has_large_pages || flags.unwrap().contains(" hg"));
    }
}
