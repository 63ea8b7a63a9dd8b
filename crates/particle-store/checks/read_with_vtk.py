"""Reads the golden files back with VTK's own reader and compares every value. Not part of CI.

    python3 -m venv venv && venv/bin/pip install vtk
    venv/bin/python crates/particle-store/checks/read_with_vtk.py
"""

import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import vtk

GOLDEN = Path(__file__).parent.parent / "tests" / "golden"
NAN = math.nan

# What tests/paraview.rs puts into the file, in the order it is permuted to.
POINTS = [(4.0, 5.5, 0.0), (0.0, 1.0, 0.0), (2.0, 3.0, 0.0)]
ARRAYS = {
    "id": ("unsigned long", [(2,), (0,), (1,)]),
    "density": ("double", [(NAN,), (1.5,), (-2.0,)]),
    "velocity": ("double", [(0.0, 8.0, 0.0), (0.25, -1.0, 0.0), (1e-300, 7.0, 0.0)]),
    "stress": ("double", [tuple(first + k for k in range(6)) for first in (20.0, 0.0, 10.0)]),
    "age": ("long", [(0,), (-1,), (2**63 - 1,)]),
    "cell": ("int", [(3, -(2**31), 0), (1, -1, 0), (2, -2, 0)]),
    'phase <α & "β">': ("unsigned char", [(255,), (0,), (1,)]),
    "body": ("unsigned int", [(2**32 - 1,), (0,), (1,)]),
}


class Complaints:
    """Errors and warnings, which VTK would only print."""

    def __init__(self, reader):
        self.heard = []
        for event in ("ErrorEvent", "WarningEvent"):
            reader.AddObserver(event, lambda *_, event=event: self.heard.append(event))


def read(name):
    reader = vtk.vtkXMLUnstructuredGridReader()
    complaints = Complaints(reader)
    reader.SetFileName(str(GOLDEN / name))
    reader.Update()
    assert not complaints.heard, (name, complaints.heard)
    return reader.GetOutput()


def same(a, b):
    return a == b or (isinstance(a, float) and math.isnan(a) and math.isnan(b))


def rows(array):
    # By GetValue, because GetTuple hands out floats, which hold no whole numbers beyond 2**53.
    n = array.GetNumberOfComponents()
    return [
        tuple(array.GetValue(n * row + k) for k in range(n))
        for row in range(array.GetNumberOfTuples())
    ]


def check_three():
    grid = read("three.vtu")
    assert [grid.GetPoint(k) for k in range(grid.GetNumberOfPoints())] == POINTS
    assert grid.GetNumberOfCells() == 3
    for k in range(3):
        assert grid.GetCellType(k) == vtk.VTK_VERTEX
        assert grid.GetCell(k).GetPointId(0) == k
    data = grid.GetPointData()
    assert [data.GetArrayName(k) for k in range(data.GetNumberOfArrays())] == list(ARRAYS)
    for name, (number, expected) in ARRAYS.items():
        array = data.GetArray(name)
        got = rows(array)
        # Which of C's types has 64 bits depends on the platform.
        read_as = array.GetDataTypeAsString().replace("long long", "long")
        assert read_as == number, (name, read_as)
        assert len(got) == len(expected), name
        assert all(same(a, b) for x, y in zip(got, expected) for a, b in zip(x, y, strict=True)), (name, got)
    field = grid.GetFieldData()
    assert rows(field.GetArray("TimeValue")) == [(0.5,)]
    assert rows(field.GetArray("step")) == [(7,)]


def check_empty():
    grid = read("empty.vtu")
    assert (grid.GetNumberOfPoints(), grid.GetNumberOfCells()) == (0, 0)


def check_texts():
    field = read("texts.vtu").GetFieldData()
    texts = {"unit of density": "kg/m³", "body 0": "plate <1>"}
    for name, text in texts.items():
        array = field.GetAbstractArray(name)
        assert (array.GetNumberOfValues(), array.GetValue(0)) == (1, text), (name, array)
    assert rows(field.GetArray("step")) == [(7,)]


def check_series():
    root = ElementTree.parse(GOLDEN / "series.pvd").getroot()
    frames = [(float(frame.get("timestep")), frame.get("file")) for frame in root.iter("DataSet")]
    assert frames == [(0.0, "empty.vtu"), (0.5, "three.vtu")]
    for time, file in frames[1:]:
        assert rows(read(file).GetFieldData().GetArray("TimeValue")) == [(time,)]


if __name__ == "__main__":
    check_three()
    check_empty()
    check_texts()
    check_series()
    print(f"VTK {vtk.vtkVersion.GetVTKVersion()} read all of it")
