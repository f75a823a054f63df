// An estimate of the memory that grids and points take, and what the machine has.
#include "program/advice/case_checks.hpp"

#include <algorithm>
#include <fstream>
#include <sys/resource.h>
#include <unistd.h>

namespace mlgimp
{

namespace
{

/// Area or volume that two boxes share, in cells: that of lengths like 1e-200 m is no number.
double CommonCells(const Box &a, const Box &b, double cell, int dim)
{
  double area = 1;
  for (int d = 0; d < dim; ++d) area *= std::max(0.0, std::min(a.upper[d], b.upper[d]) - std::max(a.lower[d], b.lower[d])) / cell;
  return area;
}

/// Nodes and points of all levels; bodies count with their bounding boxes.
void CountAll(const Case &c, double *nodes, double *points)
{
  *nodes = *points = 0;
  for (int l = 0; l < c.levels; ++l) {
    const GridGeometry &grid = c.hierarchy.levels[l].grid;
    *nodes += static_cast<double>(grid.Nodes(0)) * grid.Nodes(1) * grid.Nodes(2);
    for (const Body &body : c.model.bodies) {
      const Box bounds = body.region->Bounds();
      const double finer = l + 1 < c.levels ? CommonCells(bounds, c.boxes[l + 1], grid.spacing, c.Dim()) : 0;
      const double cells = CommonCells(bounds, c.boxes[l], grid.spacing, c.Dim()) - finer;
      *points += std::max(0.0, cells) * std::pow(body.points_per_cell, c.Dim());
    }
  }
}

/// Bytes that this rank may use: its share of the machine, or the limit of its group or of a process.
double BytesForRank(MPI_Comm comm)
{
  MPI_Comm machine;
  rlimit limit{};
  double bytes = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE)), group = 0;
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> group) bytes = std::min(bytes, group); // "max" is no number
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  bytes /= RanksOf(machine);
  MPI_Comm_free(&machine);
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    bytes = std::min(bytes, static_cast<double>(limit.rlim_cur));
  return bytes;
}

} // namespace

double BytesNeeded(const Case &c)
{
  const double kPoint = c.Dim() == 3 ? 400 : 220,
               kNode = c.Dim() == 3 ? 300 : 200; // bytes: fields and what sorting and sweeps need beside them; nodal arrays
  double nodes, points;
  CountAll(c, &nodes, &points);
  return kPoint * points + kNode * nodes;
}

void CheckMemory(MPI_Comm comm, const Case &c)
{
  constexpr double kGigabyte = 1e9; // exact
  double nodes, points, bytes = BytesForRank(comm);
  CountAll(c, &nodes, &points);
  MPI_Allreduce(MPI_IN_PLACE, &bytes, 1, MPI_DOUBLE, MPI_MIN, comm);
  const double needed = BytesNeeded(c) / RanksOf(comm);
  if (!(needed <= bytes))
    Refuse("-cell_size {}: must fit into memory; {} points and {} nodes need about {} GB per rank, and {} GB are available",
           FormatNumber(c.cell_size), points, nodes, needed / kGigabyte, bytes / kGigabyte);
}

} // namespace mlgimp
