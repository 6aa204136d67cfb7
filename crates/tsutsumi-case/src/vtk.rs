//! Files for ParaView: material points and background-grid cells as `.vtu`, their histories as `.pvd`.
//!
//! Plain data in, files out; nothing here knows what a particle or a pressure is. Both kinds of file are VTK XML
//! unstructured grids, because `vtk` and `meshio` both read them (`meshio` has no reader for image data, `.vti`).
//!
//! # Format
//!
//! One piece, arrays appended raw, each cut into blocks of 1 MiB that are zlib streams of their own. All numbers are
//! little endian whatever the host: `Float64` values bit for bit (NaN too), `Int64` connectivity, `UInt8` cell types,
//! `UInt64` block headers
//!
//! ```text
//! [number of blocks] [block size] [size of the last block if it is short, else 0] [packed size of each block] ... data
//! ```
//!
//! The appended arrays stand in the reverse order of the XML elements that point to them. To VTK the order is all the
//! same. `meshio` 5.3 looks elements up by their offset while it overwrites the offsets of those already done, and takes
//! the first match in the document; in this order the first match is always the right one.
//!
//! The same input gives the same bytes. Every file is written under a temporary name (`.tmp` added) and renamed, so a
//! reader sees the old file or the new one, never half of one.
//!
//! # Components
//!
//! | components | meaning in ParaView | order |
//! |---|---|---|
//! | 1 | scalar | |
//! | 3 | vector; pad with zeros in 1-D and 2-D | x, y, z |
//! | 6 | symmetric tensor | xx, yy, zz, xy, **yz, xz** (not Voigt's yz, xz, xy); tensor shear |
//! | 9 | full tensor | row by row: xx, xy, xz, yx, … |
//!
//! # References
//!
//! *VTK XML file formats*, <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>; the order of six
//! components is that of `vtkMath::TensorFromSymmetricTensor`.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use thiserror::Error;

/// Bytes of raw data in one zlib block; a multiple of every number's size, as VTK demands.
const BLOCK_SIZE: usize = 1 << 20;

/// Indices up to here are exact as `f64` and leave room for the far corner.
const MAX_INDEX: usize = u32::MAX as usize - 1;

const XML_DECLARATION: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

/// VTK's cell types and the corners of a cell in VTK's order, as steps from the lowest corner along x, y, z.
const VERTEX: u8 = 1;
const LINE: (u8, &[[usize; 3]]) = (3, &[[0, 0, 0], [1, 0, 0]]);
const QUAD: (u8, &[[usize; 3]]) = (9, &[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]);
#[rustfmt::skip]
const HEXAHEDRON: (u8, &[[usize; 3]]) = (
    12,
    &[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
);

/// Why a file for ParaView was not written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum VtkError {
    /// The file system refused.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file that was to be written.
        path: PathBuf,
        /// What the file system said.
        source: io::Error,
    },
    /// An existing collection could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The collection.
        path: PathBuf,
        /// What the file system said.
        source: io::Error,
    },
    /// An existing collection holds an entry that [`Collection`] did not write.
    #[error("{}, line {line}: expected <DataSet timestep=\"…\" file=\"…\"/>, found `{found}`", path.display())]
    Entry {
        /// The collection.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// The line as it stands in the file.
        found: String,
    },
    /// A field has too few or too many numbers.
    #[error(
        "{}: field `{field}` holds {found} numbers, expected {count} × {components} components",
        path.display()
    )]
    FieldLength {
        /// The file that was to be written.
        path: PathBuf,
        /// Name of the field.
        field: String,
        /// Components of the field.
        components: usize,
        /// Points or cells in the file.
        count: usize,
        /// Numbers in the field.
        found: usize,
    },
    /// A field has no components.
    #[error("{}: field `{field}` has 0 components, expected 1 or more", path.display())]
    FieldComponents {
        /// The file that was to be written.
        path: PathBuf,
        /// Name of the field.
        field: String,
    },
    /// Two fields of a file have the same name; readers would keep one of them.
    #[error("{}: field `{field}` is given twice", path.display())]
    FieldTwice {
        /// The file that was to be written.
        path: PathBuf,
        /// Name of the field.
        field: String,
    },
    /// A name is empty or has a character that XML cannot hold, such as NUL.
    #[error("{}: {name:?} cannot be a name in an XML file", path.display())]
    Name {
        /// The file that was to be written.
        path: PathBuf,
        /// The name of a field, or of a file in a collection.
        name: String,
    },
    /// A time is not finite.
    #[error("{}: time is {time} s, expected a finite number", path.display())]
    Time {
        /// The file that was to be written.
        path: PathBuf,
        /// The time (s).
        time: f64,
    },
    /// Times of a collection do not increase.
    #[error("{}: time {time:?} s comes after {last:?} s, expected a later time", path.display())]
    TimeOrder {
        /// The collection.
        path: PathBuf,
        /// The time of the new entry (s).
        time: f64,
        /// The time of the last entry (s).
        last: f64,
    },
    /// A grid is not one of 1, 2 or 3 dimensions.
    #[error("{}: the grid has {dimension} dimensions, expected 1, 2 or 3", path.display())]
    Dimension {
        /// The file that was to be written.
        path: PathBuf,
        /// Dimensions of the grid.
        dimension: usize,
    },
    /// A side of the cells is not positive and finite.
    #[error("{}: the cells measure {spacing} m along axis {axis}, expected a positive number", path.display())]
    Spacing {
        /// The file that was to be written.
        path: PathBuf,
        /// 0, 1 or 2 for x, y or z.
        axis: usize,
        /// Side of the cells (m).
        spacing: f64,
    },
    /// A cell has an index out of range.
    #[error("{}: cell number {cell} has index {index} along axis {axis}, expected at most {max}", path.display())]
    CellIndex {
        /// The file that was to be written.
        path: PathBuf,
        /// Position of the cell in the list, from 0.
        cell: usize,
        /// 0, 1 or 2 for x, y or z.
        axis: usize,
        /// The index.
        index: usize,
        /// Largest index allowed: 0 along axes that the grid does not have.
        max: usize,
    },
}

/// A named field with `components` numbers per point or cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Field<'a> {
    /// Name that ParaView shows; any text, escaped as XML needs it. Put the unit here if it is to be seen.
    pub name: &'a str,
    /// Numbers per point or cell, at least 1. The module's table says how ParaView reads 1, 3, 6 and 9.
    pub components: usize,
    /// `count × components` numbers, all components of the first point or cell first. Unit: the caller's.
    pub data: Cow<'a, [f64]>,
}

impl<'a> Field<'a> {
    /// A field of `components` numbers per point or cell, borrowed (`&[f64]`, `&Vec<f64>`) or given away (`Vec<f64>`).
    pub fn new(name: &'a str, components: usize, data: impl Into<Cow<'a, [f64]>>) -> Self {
        Self { name, components, data: data.into() }
    }

    /// A scalar field: one number per point or cell.
    pub fn scalar(name: &'a str, data: impl Into<Cow<'a, [f64]>>) -> Self {
        Self::new(name, 1, data)
    }

    /// A vector field: x, y, z per point or cell, the unit being the caller's.
    pub fn vector(name: &'a str, data: &'a [[f64; 3]]) -> Self {
        Self::new(name, 3, data.as_flattened())
    }

    /// A field of symmetric tensors: xx, yy, zz, xy, yz, xz per point or cell, tensor shear.
    pub fn symmetric_tensor(name: &'a str, data: &'a [[f64; 6]]) -> Self {
        Self::new(name, 6, data.as_flattened())
    }
}

/// Where the cells of a uniform background grid lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lattice {
    /// 1, 2 or 3: cells are written as lines along x, rectangles in x and y, or boxes.
    pub dimension: usize,
    /// Lowest corner of cell `[0, 0, 0]` (m). Along axes that the grid does not have: where it is drawn, usually 0.
    pub origin: [f64; 3],
    /// Sides of a cell (m), positive. Not read along axes that the grid does not have.
    pub spacing: [f64; 3],
}

/// Writes points with their fields to a `.vtu` file, one `VTK_VERTEX` cell per point so that they are drawn as they are.
///
/// `time` (s) becomes the field data `TimeValue`. `points` are positions (m), padded to 3-D by the caller; there may be
/// none. `fields` are point data, `points.len()` × components numbers each. The folder must exist; a file of that name
/// is replaced.
///
/// # Errors
///
/// If a field does not fit the points, a name or the time cannot be written, or the file system refuses. The file is
/// then as it was before.
pub fn write_points(path: &Path, time: f64, points: &[[f64; 3]], fields: &[Field]) -> Result<(), VtkError> {
    let connectivity: Vec<i64> = (0..points.len() as i64).collect();
    let mesh = Mesh { points, connectivity: &connectivity, points_per_cell: 1, cell_type: VERTEX };
    mesh.write(path, time, "PointData", fields)
}

/// Writes cells of a uniform background grid with their fields to a `.vtu` file; usually the active cells only.
///
/// `time` (s) becomes the field data `TimeValue`. `cells` are indices along x, y, z counted from the lattice's origin, 0
/// along axes that the grid does not have; there may be none. Cells become `VTK_LINE`, `VTK_QUAD` or `VTK_HEXAHEDRON`.
/// Neighbours share their corners: corner `i` lies at `origin + i · spacing` and is written once, numbered in order of
/// first use. `fields` are cell data, `cells.len()` × components numbers each. The folder must exist; a file of that
/// name is replaced.
///
/// # Errors
///
/// As [`write_points`], and if the lattice or an index is out of range.
pub fn write_cells(
    path: &Path,
    time: f64,
    lattice: &Lattice,
    cells: &[[usize; 3]],
    fields: &[Field],
) -> Result<(), VtkError> {
    let dimension = lattice.dimension;
    let (cell_type, corners) = match dimension {
        1 => LINE,
        2 => QUAD,
        3 => HEXAHEDRON,
        _ => {
            return Err(VtkError::Dimension { path: path.into(), dimension });
        }
    };
    for (axis, &spacing) in lattice.spacing.iter().enumerate().take(dimension) {
        if !(spacing.is_finite() && spacing > 0.0) {
            return Err(VtkError::Spacing { path: path.into(), axis, spacing });
        }
    }

    let mut points = Vec::new();
    let mut connectivity = Vec::with_capacity(cells.len() * corners.len());
    let mut numbers = HashMap::with_capacity(2 * cells.len());
    for (number, cell) in cells.iter().enumerate() {
        for (axis, &index) in cell.iter().enumerate() {
            let max = if axis < dimension { MAX_INDEX } else { 0 };
            if index > max {
                return Err(VtkError::CellIndex { path: path.into(), cell: number, axis, index, max });
            }
        }
        for step in corners {
            let corner: [usize; 3] = std::array::from_fn(|axis| cell[axis] + step[axis]);
            let point = *numbers.entry(corner).or_insert_with(|| {
                points.push(std::array::from_fn(|axis| match corner[axis] {
                    0 => lattice.origin[axis], // the spacing may be anything along axes that the grid does not have
                    index => lattice.origin[axis] + index as f64 * lattice.spacing[axis],
                }));
                points.len() as i64 - 1
            });
            connectivity.push(point);
        }
    }

    let mesh = Mesh { points: &points, connectivity: &connectivity, points_per_cell: corners.len(), cell_type };
    mesh.write(path, time, "CellData", fields)
}

/// A history of files, one per time, that ParaView opens as a whole: the `.pvd` file.
///
/// The file is rewritten at every [`push`](Self::push), so a run that is killed leaves a collection of all that it wrote.
#[derive(Debug, Clone, PartialEq)]
pub struct Collection {
    path: PathBuf,
    entries: Vec<(f64, String)>,
}

impl Collection {
    /// An empty collection at `path`. Nothing is written before the first [`push`](Self::push).
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), entries: Vec::new() }
    }

    /// The collection that an earlier run left at `path`, with its entries up to and including the time `until` (s).
    ///
    /// For runs that go on from a checkpoint. Without a file the collection is empty. Nothing is written before the
    /// first [`push`](Self::push).
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or was not written by this type.
    pub fn resume(path: impl Into<PathBuf>, until: f64) -> Result<Self, VtkError> {
        let mut collection = Self::new(path);
        let path = &collection.path;
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(source) if source.kind() == io::ErrorKind::NotFound => return Ok(collection),
            Err(source) => {
                return Err(VtkError::Read { path: path.clone(), source });
            }
        };
        for (number, line) in text.lines().enumerate().filter(|(_, line)| line.contains("<DataSet")) {
            let attribute = |key: &str| line.split_once(key)?.1.split_once('"').map(|(value, _)| value);
            let time =
                attribute(" timestep=\"").and_then(|time| time.parse().ok()).filter(|time: &f64| time.is_finite());
            let (Some(time), Some(file)) = (time, attribute(" file=\"")) else {
                return Err(VtkError::Entry { path: path.clone(), line: number + 1, found: line.into() });
            };
            if time <= until {
                collection.entries.push((time, unescape(file)));
            }
        }
        Ok(collection)
    }

    /// Appends `file` at `time` (s) and rewrites the collection.
    ///
    /// `file` is the path from the collection's folder, with `/` between folders. Times must increase.
    ///
    /// # Errors
    ///
    /// If the time is not finite or not later than the last one, the name cannot be written, or the file system refuses.
    /// The collection and its file are then as they were before.
    pub fn push(&mut self, time: f64, file: &str) -> Result<(), VtkError> {
        check_time(&self.path, time)?;
        check_name(&self.path, file)?;
        if let Some(&(last, _)) = self.entries.last()
            && time <= last
        {
            return Err(VtkError::TimeOrder { path: self.path.clone(), time, last });
        }
        self.entries.push((time, file.into()));
        self.write().inspect_err(|_| drop(self.entries.pop()))
    }

    /// Times (s) and files, in order.
    pub fn entries(&self) -> &[(f64, String)] {
        &self.entries
    }

    /// Where the collection is written.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn write(&self) -> Result<(), VtkError> {
        replace_file(&self.path, |out| {
            out.write_all(XML_DECLARATION.as_bytes())?;
            out.write_all(b"<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n")?;
            out.write_all(b"  <Collection>\n")?;
            for (time, file) in &self.entries {
                let file = escape(file);
                writeln!(out, "    <DataSet timestep=\"{time:?}\" group=\"\" part=\"0\" file=\"{file}\"/>")?;
            }
            out.write_all(b"  </Collection>\n</VTKFile>\n")
        })
    }
}

/// An unstructured grid of cells of one type.
struct Mesh<'a> {
    points: &'a [[f64; 3]],
    /// Numbers of the points of the first cell, of the second, and so on.
    connectivity: &'a [i64],
    points_per_cell: usize,
    cell_type: u8,
}

impl Mesh<'_> {
    /// Writes the mesh. `location` is `PointData` (then there are as many points as cells) or `CellData`.
    fn write(&self, path: &Path, time: f64, location: &str, fields: &[Field]) -> Result<(), VtkError> {
        let num_cells = self.connectivity.len() / self.points_per_cell;
        check_time(path, time)?;
        check_fields(path, num_cells, fields)?;

        let failed = |source| VtkError::Write { path: path.into(), source };
        let arrays = self.arrays(time, fields, num_cells).map_err(failed)?;
        let mut offset = arrays.iter().map(|array| array.packed.len()).sum();
        let mut elements = arrays.iter().map(|array| {
            offset -= array.packed.len();
            array.element(offset)
        });
        let mut section = |tag: &str, count: usize| {
            let elements: String = elements.by_ref().take(count).collect();
            format!("<{tag}>\n{elements}</{tag}>\n")
        };
        let header = [
            XML_DECLARATION,
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
             compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n",
            &section("FieldData", 1),
            &format!("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{num_cells}\">\n", self.points.len()),
            &section(location, fields.len()),
            &section("Points", 1),
            &section("Cells", 3),
            "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_",
        ]
        .concat();

        replace_file(path, |out| {
            out.write_all(header.as_bytes())?;
            for array in arrays.iter().rev() {
                out.write_all(&array.packed)?;
            }
            out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
        })
    }

    /// All arrays of the file, in the order of the document: time, fields, points and cells.
    fn arrays<'a>(&self, time: f64, fields: &'a [Field], num_cells: usize) -> io::Result<Vec<Array<'a>>> {
        let offsets: Vec<i64> = (1..=num_cells).map(|cell| (cell * self.points_per_cell) as i64).collect();
        let types = vec![self.cell_type; num_cells];

        let mut arrays = vec![Array::pack("TimeValue", "Float64", 1, &[time], f64::to_le_bytes)?];
        for field in fields {
            arrays.push(Array::pack(field.name, "Float64", field.components, &field.data, f64::to_le_bytes)?);
        }
        arrays.push(Array::pack("Points", "Float64", 3, self.points.as_flattened(), f64::to_le_bytes)?);
        arrays.push(Array::pack("connectivity", "Int64", 1, self.connectivity, i64::to_le_bytes)?);
        arrays.push(Array::pack("offsets", "Int64", 1, &offsets, i64::to_le_bytes)?);
        arrays.push(Array::pack("types", "UInt8", 1, &types, u8::to_le_bytes)?);
        Ok(arrays)
    }
}

/// An array ready to be appended.
struct Array<'a> {
    name: &'a str,
    number_type: &'static str,
    components: usize,
    tuples: usize,
    /// Block header and zlib streams.
    packed: Vec<u8>,
}

impl<'a> Array<'a> {
    /// Compresses `values`; `bytes` gives the little-endian bytes of one of them.
    fn pack<T: Copy, const N: usize>(
        name: &'a str,
        number_type: &'static str,
        components: usize,
        values: &[T],
        bytes: fn(T) -> [u8; N],
    ) -> io::Result<Self> {
        let mut raw = Vec::with_capacity(BLOCK_SIZE.min(size_of_val(values)));
        let mut streams = Vec::new();
        let mut sizes = Vec::new();
        for block in values.chunks(BLOCK_SIZE / N) {
            raw.clear();
            raw.extend(block.iter().flat_map(|&value| bytes(value)));
            let start = streams.len();
            let mut encoder = ZlibEncoder::new(&mut streams, Compression::fast());
            encoder.write_all(&raw)?;
            encoder.finish()?;
            sizes.push(streams.len() - start);
        }
        let short_block = values.len() * N % BLOCK_SIZE;

        let header = [sizes.len(), BLOCK_SIZE, short_block].into_iter().chain(sizes);
        let mut packed: Vec<u8> = header.flat_map(|size| (size as u64).to_le_bytes()).collect();
        packed.append(&mut streams);
        Ok(Self { name, number_type, components, tuples: values.len() / components, packed })
    }

    /// The XML element that points to the array, `offset` bytes into the appended data.
    fn element(&self, offset: usize) -> String {
        let Self { number_type, components, tuples, .. } = self;
        let name = escape(self.name);
        let components = if *components == 1 { String::new() } else { format!(" NumberOfComponents=\"{components}\"") };
        format!(
            "<DataArray type=\"{number_type}\" Name=\"{name}\"{components} NumberOfTuples=\"{tuples}\" \
             format=\"appended\" offset=\"{offset}\"/>\n"
        )
    }
}

/// Writes a file under a temporary name, `.tmp` added, and renames it when it is whole.
fn replace_file(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), VtkError> {
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(".tmp");
    let create = || {
        let mut out = BufWriter::new(File::create(&temporary)?);
        fill(&mut out)?;
        out.into_inner()?; // flushes, and closes the file before it is renamed
        fs::rename(&temporary, path)
    };
    create().map_err(|source| {
        let _ = fs::remove_file(&temporary); // may not exist; the first error is the one to report
        VtkError::Write { path: path.into(), source }
    })
}

fn check_time(path: &Path, time: f64) -> Result<(), VtkError> {
    if time.is_finite() { Ok(()) } else { Err(VtkError::Time { path: path.into(), time }) }
}

/// A name must not be empty, and must consist of characters that XML 1.0 can hold.
fn check_name(path: &Path, name: &str) -> Result<(), VtkError> {
    let in_xml = |c: char| matches!(c, '\t' | '\n' | '\r') || (c >= ' ' && !matches!(c, '\u{fffe}' | '\u{ffff}'));
    if !name.is_empty() && name.chars().all(in_xml) {
        Ok(())
    } else {
        Err(VtkError::Name { path: path.into(), name: name.into() })
    }
}

/// Every field has its own name and `count` × components numbers.
fn check_fields(path: &Path, count: usize, fields: &[Field]) -> Result<(), VtkError> {
    for (number, field) in fields.iter().enumerate() {
        let &Field { name, components, ref data } = field;
        check_name(path, name)?;
        if fields.iter().take(number).any(|other| other.name == name) {
            return Err(VtkError::FieldTwice { path: path.into(), field: name.into() });
        }
        if components == 0 {
            return Err(VtkError::FieldComponents { path: path.into(), field: name.into() });
        }
        if count.checked_mul(components) != Some(data.len()) {
            let (field, found) = (name.into(), data.len());
            return Err(VtkError::FieldLength { path: path.into(), field, components, count, found });
        }
    }
    Ok(())
}

/// What stands for a character in an XML attribute; white space too, or readers would turn it into blanks.
const ESCAPES: [(char, &str); 8] = [
    ('&', "&amp;"),
    ('<', "&lt;"),
    ('>', "&gt;"),
    ('"', "&quot;"),
    ('\'', "&apos;"),
    ('\t', "&#9;"),
    ('\n', "&#10;"),
    ('\r', "&#13;"),
];

fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match ESCAPES.iter().find(|(plain, _)| *plain == c) {
            Some((_, entity)) => escaped.push_str(entity),
            None => escaped.push(c),
        }
    }
    escaped
}

/// Undoes [`escape`]. The ampersand comes last, so that `&amp;lt;` gives `&lt;`.
fn unescape(text: &str) -> String {
    ESCAPES.iter().rev().fold(text.to_owned(), |text, (plain, entity)| text.replace(entity, &plain.to_string()))
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use flate2::read::ZlibDecoder;

    use super::*;

    /// A folder of its own for each test, removed at the end.
    struct Folder(PathBuf);

    impl Folder {
        fn new(test: &str) -> Self {
            let folder = std::env::temp_dir().join(format!("tsutsumi-vtk-{}-{test}", std::process::id()));
            fs::create_dir_all(&folder).unwrap();
            Self(folder)
        }

        fn file(&self, name: &str) -> PathBuf {
            self.0.join(name)
        }

        fn names(&self) -> Vec<String> {
            let mut names: Vec<_> =
                fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
            names.sort();
            names
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    /// A `.vtu` file taken apart by the description of the format, not by the code that wrote it.
    struct Decoded {
        header: String,
        appended: Vec<u8>,
    }

    impl Decoded {
        fn read(path: &Path) -> Self {
            let bytes = fs::read(path).unwrap();
            let head = &bytes[..bytes.len().min(10_000)];
            let start_tag = b"<AppendedData encoding=\"raw\">\n_";
            let end_tag = b"\n</AppendedData>\n</VTKFile>\n";
            let start = head.windows(start_tag.len()).position(|window| window == start_tag).unwrap();
            assert!(bytes.ends_with(end_tag));
            Self {
                header: String::from_utf8(bytes[..start].to_vec()).unwrap(),
                appended: bytes[start + start_tag.len()..bytes.len() - end_tag.len()].to_vec(),
            }
        }

        /// The element with the name as it stands in the XML.
        fn element(&self, name: &str) -> &str {
            let key = format!("Name=\"{name}\"");
            let lines: Vec<_> = self.header.lines().filter(|line| line.contains(&key)).collect();
            assert_eq!(lines.len(), 1, "{key} in {}", self.header);
            lines[0]
        }

        fn attribute<'a>(line: &'a str, key: &str) -> &'a str {
            let start = line.find(&format!(" {key}=\"")).unwrap() + key.len() + 3;
            line[start..].split('"').next().unwrap()
        }

        fn section(&self, tag: &str) -> &str {
            let (_, rest) = self.header.split_once(&format!("<{tag}>")).unwrap();
            rest.split_once(&format!("</{tag}>")).unwrap().0
        }

        fn bytes(&self, name: &str) -> Vec<u8> {
            let start: usize = Self::attribute(self.element(name), "offset").parse().unwrap();
            let word = |i: usize| {
                let at = start + 8 * i;
                u64::from_le_bytes(self.appended[at..at + 8].try_into().unwrap()) as usize
            };
            let (num_blocks, block_size, short_block) = (word(0), word(1), word(2));
            let mut at = start + 8 * (3 + num_blocks);
            let mut bytes = Vec::new();
            for block in 0..num_blocks {
                let packed_size = word(3 + block);
                let mut raw = Vec::new();
                let mut stream = ZlibDecoder::new(&self.appended[at..at + packed_size]);
                stream.read_to_end(&mut raw).unwrap();
                assert_eq!(stream.total_in() as usize, packed_size);
                let is_short = block + 1 == num_blocks && short_block > 0;
                assert_eq!(raw.len(), if is_short { short_block } else { block_size });
                bytes.extend(raw);
                at += packed_size;
            }
            bytes
        }

        fn bits(&self, name: &str) -> Vec<u64> {
            assert_eq!(Self::attribute(self.element(name), "type"), "Float64");
            self.bytes(name).chunks_exact(8).map(|word| u64::from_le_bytes(word.try_into().unwrap())).collect()
        }

        fn integers(&self, name: &str) -> Vec<i64> {
            assert_eq!(Self::attribute(self.element(name), "type"), "Int64");
            self.bytes(name).chunks_exact(8).map(|word| i64::from_le_bytes(word.try_into().unwrap())).collect()
        }
    }

    fn bits(values: &[f64]) -> Vec<u64> {
        values.iter().map(|value| value.to_bits()).collect()
    }

    /// Numbers without a pattern (splitmix64), any bits: infinities, subnormals and NaN with payloads among them.
    fn noise(count: usize) -> Vec<f64> {
        let mut state = 7_u64;
        let mut next = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            f64::from_bits(z ^ (z >> 31))
        };
        (0..count).map(|_| next()).collect()
    }

    const UNIT: Lattice = Lattice { dimension: 3, origin: [0.0; 3], spacing: [1.0; 3] };

    #[test]
    fn points_come_back_bit_for_bit() {
        let folder = Folder::new("points");
        let path = folder.file("p.vtu");
        let points = [[0.1, -0.0, 5e-324], [1.0, f64::MAX, -2.0], [0.3, 0.2, 0.1]];
        let pressure = [f64::NAN, f64::from_bits(0xfff4_0000_0000_0abc), f64::NEG_INFINITY];
        let displacement = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 1.0 / 3.0]];
        let stress = [[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]; 3];
        let fields = [
            Field::scalar("pressure", &pressure),
            Field::vector("displacement", &displacement),
            Field::symmetric_tensor("stress", &stress),
            Field::new("full", 9, noise(27)),
        ];
        write_points(&path, 0.1, &points, &fields).unwrap();

        let file = Decoded::read(&path);
        assert!(file.header.contains("NumberOfPoints=\"3\" NumberOfCells=\"3\""));
        assert!(file.header.contains("byte_order=\"LittleEndian\" header_type=\"UInt64\""));
        assert_eq!(file.bits("TimeValue"), bits(&[0.1]));
        assert_eq!(file.bits("Points"), bits(points.as_flattened()));
        assert_eq!(file.bits("pressure"), bits(&pressure));
        assert_eq!(file.bits("displacement"), bits(displacement.as_flattened()));
        assert_eq!(file.bits("stress"), bits(stress.as_flattened()));
        assert_eq!(file.bits("full"), bits(&noise(27)));
        assert_eq!(file.integers("connectivity"), [0, 1, 2]);
        assert_eq!(file.integers("offsets"), [1, 2, 3]);
        assert_eq!(file.bytes("types"), [1, 1, 1]);

        assert!(file.section("FieldData").contains(file.element("TimeValue")));
        for (name, components) in [("displacement", "3"), ("stress", "6"), ("full", "9")] {
            assert!(file.section("PointData").contains(file.element(name)));
            assert_eq!(Decoded::attribute(file.element(name), "NumberOfComponents"), components);
        }
        assert!(!file.element("pressure").contains("NumberOfComponents"));
        assert_eq!(folder.names(), ["p.vtu"]);
    }

    #[test]
    fn long_arrays_are_cut_into_blocks() {
        let folder = Folder::new("blocks");
        let path = folder.file("p.vtu");
        let count = BLOCK_SIZE / 8 / 2;
        // Just below, at and just above one block (2 components), and one and a half (3 components).
        for count in [count - 1, count, count + 1] {
            let points = vec![[0.5; 3]; count];
            write_points(&path, 0.0, &points, &[Field::new("b", 2, noise(2 * count))]).unwrap();
            let file = Decoded::read(&path);
            assert!(file.bits("b") == bits(&noise(2 * count)), "{count} points");
            assert!(file.bits("Points") == bits(points.as_flattened()), "{count} points");
            assert_eq!(file.integers("connectivity"), (0..count as i64).collect::<Vec<_>>());
        }
    }

    /// Arrays follow each other without gaps, the last element of the document first: what `meshio` relies on.
    #[test]
    fn appended_arrays_stand_in_reverse_order() {
        let folder = Folder::new("order");
        let path = folder.file("p.vtu");
        let fields = [Field::scalar("a", noise(5)), Field::scalar("b", noise(5))];
        write_points(&path, 0.0, &[[0.0; 3]; 5], &fields).unwrap();
        let file = Decoded::read(&path);
        let offsets: Vec<usize> = file
            .header
            .lines()
            .filter(|line| line.starts_with("<DataArray"))
            .map(|line| Decoded::attribute(line, "offset").parse().unwrap())
            .collect();
        assert_eq!(offsets.len(), 7);
        assert!(offsets.windows(2).all(|pair| pair[0] > pair[1]), "{offsets:?}");
        assert_eq!(offsets[6], 0);
        // The first array of the document ends where the data end: one block, packed size in the fourth word.
        let size = u64::from_le_bytes(file.appended[offsets[0] + 24..offsets[0] + 32].try_into().unwrap());
        assert_eq!(offsets[0] + 32 + size as usize, file.appended.len());
    }

    #[test]
    fn neighbouring_cells_share_their_corners() {
        let folder = Folder::new("cells");
        let path = folder.file("c.vtu");

        // o---o   o---o      a gap, and corners at 0.1 · 3 that sums of 0.1 would miss
        let line = Lattice { dimension: 1, origin: [0.5, 7.0, 8.0], spacing: [0.1, f64::NAN, 0.0] };
        write_cells(&path, 2.0, &line, &[[0, 0, 0], [1, 0, 0], [3, 0, 0]], &[]).unwrap();
        let file = Decoded::read(&path);
        let x = [0.5, 0.5 + 0.1, 0.5 + 2.0 * 0.1, 0.5 + 3.0 * 0.1, 0.5 + 4.0 * 0.1];
        let points: Vec<f64> = x.iter().flat_map(|&x| [x, 7.0, 8.0]).collect();
        assert_eq!(file.bits("Points"), bits(&points));
        assert_eq!(file.integers("connectivity"), [0, 1, 1, 2, 3, 4]);
        assert_eq!(file.integers("offsets"), [2, 4, 6]);
        assert_eq!(file.bytes("types"), [3, 3, 3]);
        assert_eq!(file.bits("TimeValue"), bits(&[2.0]));

        // 3---2---5
        // | 0 | 1 |
        // 0---1---4
        let plane = Lattice { dimension: 2, origin: [-1.0, 2.0, 0.0], spacing: [2.0, 0.25, 1.0] };
        let pressure = [1.5, f64::NAN];
        write_cells(&path, 0.0, &plane, &[[0, 4, 0], [1, 4, 0]], &[Field::scalar("pressure", &pressure)]).unwrap();
        let file = Decoded::read(&path);
        let xy = [[-1.0, 3.0], [1.0, 3.0], [1.0, 3.25], [-1.0, 3.25], [3.0, 3.0], [3.0, 3.25]];
        let points: Vec<f64> = xy.iter().flat_map(|&[x, y]| [x, y, 0.0]).collect();
        assert_eq!(file.bits("Points"), bits(&points));
        assert_eq!(file.integers("connectivity"), [0, 1, 2, 3, 1, 4, 5, 2]);
        assert_eq!(file.integers("offsets"), [4, 8]);
        assert_eq!(file.bytes("types"), [9, 9]);
        assert_eq!(file.bits("pressure"), bits(&pressure));
        assert!(file.section("CellData").contains(file.element("pressure")));

        // Two boxes on top of each other have 12 corners.
        write_cells(&path, 0.0, &UNIT, &[[0, 0, 0], [0, 0, 1]], &[]).unwrap();
        let file = Decoded::read(&path);
        assert!(file.header.contains("NumberOfPoints=\"12\" NumberOfCells=\"2\""));
        assert_eq!(file.integers("connectivity"), [0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 7, 8, 9, 10, 11]);
        assert_eq!(file.bytes("types"), [12, 12]);
    }

    /// VTK's order: positive area and volume by the cross products of the first edges, every corner at its place.
    #[test]
    fn cells_are_not_inside_out() {
        let folder = Folder::new("orientation");
        let path = folder.file("c.vtu");
        write_cells(&path, 0.0, &UNIT, &[[0, 0, 0]], &[]).unwrap();
        let file = Decoded::read(&path);
        let values: Vec<f64> = file.bits("Points").into_iter().map(f64::from_bits).collect();
        let corners: Vec<_> = file.integers("connectivity").iter().map(|&i| &values[3 * i as usize..][..3]).collect();
        // The description in VTK's manual: (0,1,2,3) is the base, (4,5,6,7) lies above it in the same sense.
        let base = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        for (i, [x, y]) in base.into_iter().enumerate() {
            assert_eq!(corners[i], [x, y, 0.0]);
            assert_eq!(corners[i + 4], [x, y, 1.0]);
        }
    }

    #[test]
    fn nothing_to_write_is_a_valid_file() {
        let folder = Folder::new("empty");
        let path = folder.file("e.vtu");
        let fields = [Field::scalar("pressure", &[]), Field::vector("velocity", &[])];
        for write in
            [(|path, fields| write_points(path, 1.0, &[], fields)) as fn(&Path, &[Field]) -> _, |path, fields| {
                write_cells(path, 1.0, &UNIT, &[], fields)
            }]
        {
            write(&path, &fields).unwrap();
            let file = Decoded::read(&path);
            assert!(file.header.contains("NumberOfPoints=\"0\" NumberOfCells=\"0\""));
            for name in ["pressure", "velocity", "Points", "connectivity", "offsets", "types"] {
                assert_eq!(file.bytes(name), [0_u8; 0], "{name}");
            }
            assert_eq!(file.bits("TimeValue"), bits(&[1.0]));
        }
    }

    #[test]
    fn same_input_gives_same_bytes() {
        let folder = Folder::new("deterministic");
        let cells: Vec<[usize; 3]> = (0..500).map(|i| [i % 7, i % 11, i % 13]).collect();
        for name in ["a", "b"] {
            let field = Field::scalar("pressure", noise(500));
            write_cells(&folder.file(name), 0.5, &UNIT, &cells, &[field]).unwrap();
        }
        assert_eq!(fs::read(folder.file("a")).unwrap(), fs::read(folder.file("b")).unwrap());
    }

    #[test]
    fn names_are_escaped() {
        let folder = Folder::new("names");
        let path = folder.file("n.vtu");
        let name = "σ' <\"p\" & q>\t(kPa)";
        write_points(&path, 0.0, &[[0.0; 3]], &[Field::scalar(name, &[1.0])]).unwrap();
        let file = Decoded::read(&path);
        assert_eq!(file.bits("σ&apos; &lt;&quot;p&quot; &amp; q&gt;&#9;(kPa)"), bits(&[1.0]));
        assert_eq!(unescape(&escape("&amp;lt; &#10;\n&")), "&amp;lt; &#10;\n&");

        for bad in ["", "a\0", "\u{1b}[1m", "\u{ffff}"] {
            let error = write_points(&path, 0.0, &[[0.0; 3]], &[Field::scalar(bad, &[1.0])]).unwrap_err();
            assert!(matches!(error, VtkError::Name { name, .. } if name == bad));
        }
    }

    #[test]
    fn fields_that_do_not_fit_are_refused() {
        let folder = Folder::new("fields");
        let path = folder.file("f.vtu");
        let write = |fields: &[Field]| write_points(&path, 0.0, &[[0.0; 3]; 2], fields).unwrap_err();

        let error = write(&[Field::scalar("pressure", &[1.0, 2.0]), Field::new("stress", 6, vec![0.0; 11])]);
        assert!(matches!(&error, VtkError::FieldLength { components: 6, count: 2, found: 11, .. }));
        let text = error.to_string();
        assert!(text.ends_with("f.vtu: field `stress` holds 11 numbers, expected 2 × 6 components"), "{text}");

        let error = write(&[Field::scalar("pressure", &[1.0, 2.0]), Field::scalar("pressure", &[1.0, 2.0])]);
        assert!(matches!(error, VtkError::FieldTwice { field, .. } if field == "pressure"));
        let error = write(&[Field::new("pressure", 0, Vec::new())]);
        assert!(matches!(error, VtkError::FieldComponents { field, .. } if field == "pressure"));
        let error = write(&[Field::new("pressure", usize::MAX, vec![0.0; 2])]);
        assert!(matches!(error, VtkError::FieldLength { .. }));
        // As many numbers as there are corners, not cells.
        let corners = Field::scalar("pressure", &[0.0; 8]);
        let error = write_cells(&path, 0.0, &UNIT, &[[0; 3]], &[corners]).unwrap_err();
        assert!(matches!(error, VtkError::FieldLength { count: 1, found: 8, .. }));
        assert!(folder.names().is_empty());
    }

    #[test]
    fn lattices_and_times_out_of_range_are_refused() {
        let folder = Folder::new("range");
        let path = folder.file("r.vtu");
        let write = |lattice, cell| write_cells(&path, 0.0, &lattice, &[[0; 3], cell], &[]).unwrap_err();

        for dimension in [0, 4] {
            let error = write(Lattice { dimension, ..UNIT }, [0; 3]);
            assert!(matches!(error, VtkError::Dimension { dimension: found, .. } if found == dimension));
        }
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = write(Lattice { spacing: [1.0, bad, 1.0], ..UNIT }, [0; 3]);
            assert!(matches!(error, VtkError::Spacing { axis: 1, .. }));
        }
        let error = write(Lattice { dimension: 2, ..UNIT }, [0, 0, 1]);
        assert!(matches!(error, VtkError::CellIndex { cell: 1, axis: 2, index: 1, max: 0, .. }));
        let error = write(UNIT, [usize::MAX, 0, 0]);
        assert!(matches!(error, VtkError::CellIndex { cell: 1, axis: 0, index: usize::MAX, .. }));
        for bad in [f64::NAN, f64::INFINITY] {
            let error = write_points(&path, bad, &[], &[]).unwrap_err();
            assert!(matches!(error, VtkError::Time { .. }));
        }
        assert!(folder.names().is_empty());
    }

    #[test]
    fn failed_writes_leave_things_as_they_were() {
        let folder = Folder::new("failed");
        let path = folder.file("missing/p.vtu");
        let error = write_points(&path, 0.0, &[], &[]).unwrap_err();
        assert!(error.to_string().contains("missing/p.vtu"), "{error}");
        assert!(matches!(&error, VtkError::Write { source, .. } if source.kind() == io::ErrorKind::NotFound));
        assert!(std::error::Error::source(&error).is_some());

        // A folder that is not empty stands in the way of the rename: the temporary file goes.
        fs::create_dir_all(folder.file("taken.vtu/in")).unwrap();
        let error = write_points(&folder.file("taken.vtu"), 0.0, &[], &[]).unwrap_err();
        assert!(matches!(error, VtkError::Write { .. }));
        assert_eq!(folder.names(), ["taken.vtu"]);

        // The writer stops half way: the old file stays.
        let path = folder.file("old");
        fs::write(&path, "old").unwrap();
        let error = replace_file(&path, |out| {
            out.write_all(b"half a fi")?;
            Err(io::Error::other("disk full"))
        });
        assert!(error.unwrap_err().to_string().ends_with("disk full"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(folder.names(), ["old", "taken.vtu"]);
    }

    #[test]
    fn collections_grow_and_stay_readable() {
        let folder = Folder::new("collection");
        let path = folder.file("particles.pvd");
        let mut collection = Collection::new(&path);
        assert!(folder.names().is_empty());
        collection.push(0.0, "vtk/particles_0.vtu").unwrap();
        collection.push(0.1 + 0.2, "vtk/a & b.vtu").unwrap();
        assert_eq!(
            fs::read_to_string(&path).unwrap(),
            r#"<?xml version="1.0" encoding="UTF-8"?>
<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">
  <Collection>
    <DataSet timestep="0.0" group="" part="0" file="vtk/particles_0.vtu"/>
    <DataSet timestep="0.30000000000000004" group="" part="0" file="vtk/a &amp; b.vtu"/>
  </Collection>
</VTKFile>
"#
        );
        assert_eq!(folder.names(), ["particles.pvd"]);

        for early in [0.1, 0.1 + 0.2] {
            let error = collection.push(early, "c.vtu").unwrap_err();
            assert!(matches!(error, VtkError::TimeOrder { time, last, .. } if time == early && last == 0.1 + 0.2));
        }
        assert!(matches!(collection.push(f64::NAN, "c.vtu"), Err(VtkError::Time { .. })));
        assert!(matches!(collection.push(1.0, ""), Err(VtkError::Name { .. })));
        assert_eq!(collection.entries().len(), 2);
        assert_eq!(Collection::resume(&path, 9.0).unwrap(), collection);
    }

    #[test]
    fn collections_resume_from_a_time() {
        let folder = Folder::new("resume");
        let path = folder.file("grid.pvd");
        assert_eq!(Collection::resume(&path, 1.0).unwrap(), Collection::new(&path));

        let names = ["a", "σ' <&amp;> \"b\"", "c"];
        let mut whole = Collection::new(&path);
        for (time, name) in [1e-300, 1.0, 2.5e20].into_iter().zip(names) {
            whole.push(time, name).unwrap();
        }
        assert_eq!(Collection::resume(&path, f64::INFINITY).unwrap(), whole);
        let mut resumed = Collection::resume(&path, 1.0).unwrap();
        assert_eq!(resumed.entries(), &whole.entries()[..2]);
        resumed.push(1.5, "d").unwrap();
        assert_eq!(Collection::resume(&path, 2.0).unwrap(), resumed);

        fs::write(&path, "\n  <DataSet timestep=\"one\" file=\"a\"/>\n").unwrap();
        let error = Collection::resume(&path, 1.0).unwrap_err();
        assert!(matches!(error, VtkError::Entry { line: 2, .. }), "{error}");
        fs::write(&path, [0xff, 0xfe]).unwrap();
        assert!(matches!(Collection::resume(&path, 1.0), Err(VtkError::Read { .. })));
    }

    #[test]
    fn failed_pushes_are_not_kept() {
        let folder = Folder::new("push");
        let mut collection = Collection::new(folder.file("missing/grid.pvd"));
        assert!(matches!(collection.push(0.0, "a.vtu"), Err(VtkError::Write { .. })));
        assert!(collection.entries().is_empty());
        fs::create_dir(folder.file("missing")).unwrap();
        collection.push(0.0, "a.vtu").unwrap();
        assert_eq!(collection.entries(), [(0.0, "a.vtu".to_owned())]);
    }
}
