"""What ParaView makes of series of points: of each file given, by each reader, (time, points, cells, sum of the stress) of every step."""
import json
import sys

import numpy
from paraview import servermanager, simple
from vtkmodules.numpy_interface import dataset_adapter


def blocks_of(reader):
    """The levels that a reader has read."""
    shown = dataset_adapter.WrapDataObject(servermanager.Fetch(reader))
    return list(shown) if hasattr(shown, "Iterator") or hasattr(shown, "__iter__") else [shown]


def steps(reader):
    reader.UpdatePipelineInformation()
    for time in reader.TimestepValues:
        reader.UpdatePipeline(time)
        blocks = blocks_of(reader)
        cells = [block.Cells.reshape(-1, 2) for block in blocks]  # points of a cell, and the only one
        for block, cell in zip(blocks, cells):
            assert numpy.array_equal(cell, [(1, point) for point in range(block.GetNumberOfPoints())])
        yield (time, sum(block.GetNumberOfPoints() for block in blocks), sum(map(len, cells)),
               sum(float(numpy.sum(block.PointData["stress"])) for block in blocks))


def readers(path):
    yield simple.OpenDataFile(path)  # as `File, Open` does
    yield simple.XDMFReader(FileNames=[path])


print(json.dumps([[(reader.GetXMLName(), list(steps(reader))) for reader in readers(path)] for path in sys.argv[1:]]))
