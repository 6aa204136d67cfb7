//! Reads back the particles that [`vtk`](crate::vtk) wrote, for figures of runs that have ended.
//!
//! It knows that one format: arrays of 64-bit numbers, appended raw in blocks of zlib; see there.

use std::fs;
use std::io::Read;
use std::path::Path;

use flate2::read::ZlibDecoder;

/// What stands between the elements and the data.
const APPENDED: &[u8] = b"<AppendedData encoding=\"raw\">\n_";

/// The files of a `.pvd` with their times (s), in its order.
///
/// # Errors
/// What is wrong with the file, in words.
pub(crate) fn read_collection(path: &Path) -> Result<Vec<(f64, String)>, String> {
    let text = fs::read_to_string(path).map_err(|error| format!("cannot read `{}`: {error}", path.display()))?;
    let entry = |line: &str| {
        let time = attribute(line, "timestep")?.parse().ok()?;
        Some((time, attribute(line, "file")?.to_owned()))
    };
    let entries = text.split("<DataSet ").skip(1).map(entry).collect::<Option<Vec<_>>>();
    entries.ok_or_else(|| format!("`{}` is damaged", path.display()))
}

/// Some arrays of a `.vtu`, by name and in the order asked for, as flat lists of numbers.
///
/// # Errors
/// What is wrong with the file, in words.
pub(crate) fn read_arrays<const N: usize>(path: &Path, names: [&str; N]) -> Result<[Vec<f64>; N], String> {
    let bytes = fs::read(path).map_err(|error| format!("cannot read `{}`: {error}", path.display()))?;
    let damaged = || format!("`{}` is damaged", path.display());
    let start = bytes.windows(APPENDED.len()).position(|window| window == APPENDED).ok_or_else(damaged)?;
    let head = std::str::from_utf8(&bytes[..start]).map_err(|_| damaged())?;
    let data = &bytes[start + APPENDED.len()..];
    let mut arrays = [const { Vec::new() }; N];
    for (array, name) in arrays.iter_mut().zip(names) {
        let named = |element: &&str| attribute(element, "Name") == Some(name);
        let element = head.split("<DataArray ").skip(1).find(named);
        let element = element.ok_or_else(|| format!("`{}` has no `{name}`", path.display()))?;
        let offset = attribute(element, "offset").and_then(|offset| offset.parse::<usize>().ok());
        *array = offset.and_then(|offset| numbers(data.get(offset..)?)).ok_or_else(damaged)?;
    }
    Ok(arrays)
}

/// An attribute of an element, without entities.
fn attribute<'a>(element: &'a str, name: &str) -> Option<&'a str> {
    let element = element.split('>').next()?;
    let (_, value) = element.split_once(&format!("{name}=\""))?;
    value.split('"').next()
}

/// The numbers of an appended array: number of blocks, their size, that of a last short one, packed sizes, streams.
fn numbers(data: &[u8]) -> Option<Vec<f64>> {
    let word = |index: usize| {
        let bytes = data.get(8 * index..8 * index + 8)?.try_into().ok()?;
        usize::try_from(u64::from_le_bytes(bytes)).ok()
    };
    let blocks = word(0)?;
    let mut place = 8 * blocks.checked_add(3)?;
    let mut raw = Vec::new();
    for block in 0..blocks {
        let end = place.checked_add(word(3 + block)?)?;
        ZlibDecoder::new(data.get(place..end)?).read_to_end(&mut raw).ok()?;
        place = end;
    }
    let (numbers, rest) = raw.as_chunks::<8>();
    rest.is_empty().then(|| numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vtk::{Collection, Field, write_points};

    #[test]
    fn what_was_written_is_read_bit_for_bit() {
        let folder = std::env::temp_dir().join(format!("tsutsumi-vtk-reader-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        // More than one block of 1 MiB.
        let points: Vec<[f64; 3]> = (0..60_000).map(|i| [f64::from(i).sqrt(), -0.0, f64::NAN]).collect();
        let pressure: Vec<f64> = (0..60_000).map(|i| f64::from(i) / 3.0).collect();
        let file = folder.join("particles.vtu");
        write_points(&file, 0.1, &points, &[Field::scalar("pressure", &pressure)]).unwrap();
        let mut collection = Collection::new(folder.join("particles.pvd"));
        collection.push(0.1, "particles.vtu").unwrap();
        assert_eq!(read_collection(&folder.join("particles.pvd")).unwrap(), [(0.1, "particles.vtu".to_owned())]);
        let [position, again] = read_arrays(&file, ["Points", "pressure"]).unwrap();
        let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&position), bits(points.as_flattened()));
        assert_eq!(bits(&again), bits(&pressure));
        assert!(read_arrays(&file, ["stress"]).unwrap_err().ends_with("has no `stress`"));
        let bytes = fs::read(&file).unwrap();
        fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
        assert!(read_arrays(&file, ["Points", "pressure"]).unwrap_err().ends_with("is damaged"));
        fs::remove_dir_all(&folder).unwrap();
    }
}
