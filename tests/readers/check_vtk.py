#!/usr/bin/env python3
"""Reads the ParaView files of a results folder with two independent readers and compares what they see.

    python3 -m venv .venv && .venv/bin/pip install vtk==9.7.2 meshio==5.3.5 numpy==2.4.6
    .venv/bin/python check_vtk.py RESULTS_DIR [--expect-points N] [--only particles|grid] [--png FILE]

Follows every entry of RESULTS_DIR/particles.pvd and grid.pvd, reads the .vtu with VTK (vtkXMLUnstructuredGridReader)
and with meshio, and demands: both agree bit for bit on points, cells, cell types and all fields; times in the .pvd
increase and equal `TimeValue` in the files; particles are vertices, one per point; cells of the grid are lines,
quadrilaterals or hexahedra of positive size, their corners not repeated, every corner used.

meshio 5.3 cannot read files without cells (IndexError); those are read with VTK alone.

Prints "N files, M points, ok" (points of the particle files and the grid files together) and exits with 0; otherwise
prints what is wrong with which file, and exits with 1.
"""

import argparse
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import meshio
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

MESHIO_TYPES = {1: "vertex", 3: "line", 9: "quad", 12: "hexahedron"}
CORNERS = {1: 1, 3: 2, 9: 4, 12: 8}
SIZES = {3: "Length", 9: "Area", 12: "Volume"}


class Wrong(Exception):
    """What a file should not be."""


def demand(condition, message):
    if not condition:
        raise Wrong(message)


def entries(collection):
    """(time, file) for each entry of a .pvd file."""
    demand(collection.is_file(), "no such file")
    try:
        root = ElementTree.parse(collection).getroot()
    except ElementTree.ParseError as error:
        raise Wrong(f"not XML: {error}") from error
    demand(root.tag == "VTKFile" and root.get("type") == "Collection", "not a VTK collection")
    found = []
    for element in root.iterfind("Collection/DataSet"):
        time, file = element.get("timestep"), element.get("file")
        demand(time is not None and file is not None, "a DataSet without timestep or file")
        found.append((float(time), collection.parent / file))
    demand(found, "no entries")
    for (before, _), (after, _) in zip(found, found[1:]):
        demand(before < after, f"time {after!r} comes after {before!r}")
    return found


def fields_of(attributes):
    """Name -> array (count, components) of VTK's point, cell or field data."""
    arrays = [attributes.GetArray(i) for i in range(attributes.GetNumberOfArrays())]
    return {a.GetName(): vtk_to_numpy(a).reshape(-1, a.GetNumberOfComponents()) for a in arrays}


def read_with_vtk(file):
    vtk.vtkLogger.SetStderrVerbosity(vtk.vtkLogger.VERBOSITY_OFF)
    log = vtk.vtkStringOutputWindow()  # VTK prints errors of all its parts and goes on
    vtk.vtkOutputWindow.SetInstance(log)
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(file))
    reader.Update()
    demand(not log.GetOutput().strip(), f"vtk says: {' '.join(log.GetOutput().split())}")
    demand(reader.GetErrorCode() == 0, f"vtk's error code is {reader.GetErrorCode()}")
    return reader.GetOutput()


def same(ours, theirs):
    """Equal shape, type and bits: NaN equals NaN, 0 does not equal -0."""
    return ours.shape == theirs.shape and ours.dtype == theirs.dtype and ours.tobytes() == theirs.tobytes()


def compare_fields(where, by_vtk, by_meshio):
    demand(set(by_vtk) == set(by_meshio), f"{where}: vtk has {sorted(by_vtk)}, meshio has {sorted(by_meshio)}")
    for name, ours in by_vtk.items():
        theirs = np.asarray(by_meshio[name])
        theirs = theirs.reshape(-1, 1) if theirs.ndim == 1 else theirs
        demand(ours.dtype == np.float64, f"{where}, field {name!r}: {ours.dtype}, expected float64")
        demand(same(ours, theirs), f"{where}, field {name!r}: vtk and meshio differ")


def check_grid_cells(grid, points, corners, cell_type):
    demand(len(np.unique(points, axis=0)) == len(points), "corners are repeated")
    demand(len(np.unique(corners)) == len(points), "corners that no cell uses")
    measure = vtk.vtkCellSizeFilter()
    measure.SetInputData(grid)
    measure.Update()
    size = vtk_to_numpy(measure.GetOutput().GetCellData().GetArray(SIZES[cell_type]))
    demand(np.all(size > 0.0), f"cell {int(np.argmin(size))} has the size {size.min()}")
    # The boxes of a uniform grid: the size is the product of the sides of the box around the corners.
    box = np.ptp(points[corners], axis=1)
    box[box == 0.0] = 1.0
    demand(np.allclose(size, box.prod(axis=1), rtol=1e-9), "corners of the cells in the wrong order")


def check_file(kind, time, file, expect_points):
    """Checks one .vtu and gives the number of its points."""
    demand(file.is_file(), "no such file")
    grid = read_with_vtk(file)
    num_points, num_cells = grid.GetNumberOfPoints(), grid.GetNumberOfCells()
    time_value = fields_of(grid.GetFieldData()).get("TimeValue")
    demand(time_value is not None, "no TimeValue")
    demand(time_value.tolist() == [[time]], f"TimeValue {time_value.tolist()}, but {time!r} in the collection")
    if expect_points is not None and kind == "particles":
        demand(num_points == expect_points, f"{num_points} points, expected {expect_points}")
    if num_cells == 0:
        demand(num_points == 0, f"{num_points} points without cells")
        return 0

    try:
        mesh = meshio.read(file)
    except (Exception, SystemExit) as error:  # meshio's command line helpers exit; anything it throws is a failure
        raise Wrong(f"meshio says: {type(error).__name__}: {error}") from error

    points = vtk_to_numpy(grid.GetPoints().GetData())
    demand(len(mesh.points) == num_points, f"{num_points} points in vtk, {len(mesh.points)} in meshio")
    demand(same(points, mesh.points), "vtk and meshio differ in the points")

    types = {grid.GetCellType(i) for i in range(num_cells)}
    demand(len(types) == 1, f"cells of types {sorted(types)}, expected one type")
    cell_type = types.pop()
    allowed = [1] if kind == "particles" else [3, 9, 12]
    demand(cell_type in allowed, f"cells of VTK type {cell_type}, expected {allowed}")
    names = [block.type for block in mesh.cells]
    demand(names == [MESHIO_TYPES[cell_type]], f"VTK type {cell_type}, but {names} in meshio")
    cells = grid.GetCells()
    corners = vtk_to_numpy(cells.GetConnectivityArray()).reshape(num_cells, CORNERS[cell_type])
    offsets = np.arange(num_cells + 1) * CORNERS[cell_type]
    demand(np.array_equal(vtk_to_numpy(cells.GetOffsetsArray()), offsets), "offsets of the cells")
    demand(np.array_equal(corners, mesh.cells[0].data), "vtk and meshio differ in the corners of the cells")
    demand(corners.min() >= 0 and corners.max() < num_points, "corners out of range")

    compare_fields("point data", fields_of(grid.GetPointData()), mesh.point_data)
    compare_fields("cell data", fields_of(grid.GetCellData()), {name: blocks[0] for name, blocks in mesh.cell_data.items()})
    meshio_time = np.asarray(mesh.field_data["TimeValue"]).ravel().tolist()
    demand(meshio_time == [time], f"TimeValue {meshio_time} in meshio, but {time!r} in the collection")

    if kind == "particles":
        demand(num_points == num_cells, f"{num_points} points, but {num_cells} vertices")
        demand(np.array_equal(corners.ravel(), np.arange(num_points)), "vertices out of order")
    else:
        check_grid_cells(grid, points, corners, cell_type)
    return num_points


def render(folder, png):
    """Draws the last particles (first field) and the edges of the last grid without a display."""
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(900, 700)
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1.0, 1.0, 1.0)
    window.AddRenderer(renderer)
    for kind in ("grid", "particles"):
        data = read_with_vtk(entries(folder / f"{kind}.pvd")[-1][1])
        mapper = vtk.vtkDataSetMapper()
        mapper.SetInputData(data)
        actor = vtk.vtkActor()
        actor.SetMapper(mapper)
        if kind == "particles":
            name = data.GetPointData().GetArrayName(0)
            mapper.SetScalarModeToUsePointFieldData()
            mapper.SelectColorArray(name)
            mapper.SetScalarRange(data.GetPointData().GetArray(name).GetRange())
            actor.GetProperty().SetPointSize(4.0)
        else:
            mapper.ScalarVisibilityOff()
            actor.GetProperty().SetRepresentationToWireframe()
            actor.GetProperty().SetColor(0.6, 0.6, 0.6)
        renderer.AddActor(actor)
    renderer.ResetCamera()
    if renderer.GetActors().GetLastActor().GetBounds()[5] > 0.0:
        renderer.GetActiveCamera().Azimuth(30)
        renderer.GetActiveCamera().Elevation(20)
        renderer.ResetCamera()
    window.Render()
    image = vtk.vtkWindowToImageFilter()
    image.SetInput(window)
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(str(png))
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("results", type=Path, metavar="RESULTS_DIR")
    arguments.add_argument("--expect-points", type=int, metavar="N", help="points in every particle file")
    arguments.add_argument("--only", choices=["particles", "grid"], help="check one of the two collections")
    arguments.add_argument("--png", type=Path, metavar="FILE", help="also draw the last output, without a display")
    given = arguments.parse_args()

    num_files = num_points = 0
    for kind in [given.only] if given.only else ["particles", "grid"]:
        file = given.results / f"{kind}.pvd"
        try:
            for time, file in entries(file):
                num_points += check_file(kind, time, file, given.expect_points)
                num_files += 1
        except Wrong as wrong:
            print(f"{file}: {wrong}", file=sys.stderr)
            return 1
    if given.png:
        render(given.results, given.png)
    print(f"{num_files} files, {num_points} points, ok")
    return 0


if __name__ == "__main__":
    sys.exit(main())
