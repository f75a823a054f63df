// What a rank keeps at its nodes, ghosts among them: sums, velocities, rates, strain rates and sums of cells.
#pragma once

#include "base/handle.hpp"

#include <cstddef>
#include <vector>

namespace mlgimp
{

/// What a node holds of the points around it: one cache line in every geometry.
struct alignas(64) NodeSums {
  double mass;        ///< kg
  double owned_mass;  ///< of points that this level owns; the others are copies, kg
  double momentum[3]; ///< kg m/s
  double force[3];    ///< internal, of loads and of bodies, N
};
static_assert(sizeof(NodeSums) == 64, "nodal sums travel and load as eight doubles");

/// The new velocity of a node and its change in the step, m/s.
struct NodeVelocity {
  double *velocity, *change; ///< [dim] each
};

/// What a cell holds of the points of a material in it, kg: sums of mass, and of what else is named times mass.
struct CellSums {
  double mass;
  double growth;          ///< of volume, in the step
  double relative_volume; ///< J, at the step's start
};

/// The strain rate of a cell in its middle (components as NodeLayout's) times a weight, 1/s, and that weight, in the plane as the
/// fourth of these numbers: zero where no point lies in the cell, so that it has none.
struct alignas(64) CellRate {
  double strain[6];
  double weight, unused;
};

/// Components of the nodal arrays by dimension. Velocities: as many for the new one as for its change. Rates: momentum or
/// velocity of the second extrapolation, and of the projection for XPIC; each begins a vector of four in space, of two in the
/// plane. Strain rates: xx, yy, xy in the plane, xx, yy, zz, xy in axisymmetry, xx, yy, zz, xy, yz, xz in space. They are an
/// array of their own, as most sweeps need one of the two.
struct NodeLayout {
  static constexpr int kSums = sizeof(NodeSums) / sizeof(double);
  static constexpr int Viewed(int dim) { return 1 + 3 * dim; } ///< of the vector that PETSc's viewers show
  static constexpr int Velocity(int dim) { return dim == 2 ? 4 : 8; }
  static constexpr int Rates(int dim) { return dim == 2 ? 4 : 8; }   ///< of rates, and of strain rates
  static constexpr int Projected(int dim) { return Rates(dim) / 2; } ///< place of the projection among the rates
};

/// The arrays by place of the node, see NodePartition::Place and NodeLayout. Whoever may read them may also write them.
class NodalArrays
{
public:
  /// For so many nodes. volume_averages: number of materials that keep sums at the cells; has_strain_rates: and marks.
  PetscErrorCode Create(int dim, std::ptrdiff_t nodes, int volume_averages, bool has_strain_rates);

  NodeSums *Sums() const { return sums_; }
  double *VelocityArray() const { return velocity_; }
  double *RatesArray() const { return rates_; }
  NodeVelocity Velocity(std::ptrdiff_t place) const
  {
    double *const first = velocity_ + velocity_size_ * place;
    return {first, first + velocity_size_ / 2};
  }
  double *Rates(std::ptrdiff_t place) const { return rates_ + rates_size_ * place; }
  /// Null where they are not kept.
  double *StrainRatesArray() const { return strain_rates_; }
  double *StrainRates(std::ptrdiff_t place) const { return strain_rates_ + rates_size_ * place; }
  /// Sums of a material over the points of cells: those of the cell above a node, along every axis, lie CellStride() times the
  /// node's place from the first.
  CellSums *Cells(int average) const { return cells_ + average; }
  int CellStride() const { return cell_size_; }
  /// Above zero where points lie in the cell above a node; null where they are not kept.
  double *Marks() const { return marks_; }
  /// Of `count` cells of a layer, that of even or of odd ones; until the next call with more.
  CellRate *Layer(int layer, std::ptrdiff_t count);
  /// Sums of nodes, and marks.
  void ClearSums() const;
  /// Rates, but not those of strain, and the sums of cells.
  void ClearRates() const;

  /// The values of a node as one unit of communication.
  MPI_Datatype SumsUnit() const { return sums_unit_; }
  MPI_Datatype VelocityUnit() const { return velocity_unit_; }

private:
  /// With 64-byte alignment no node lies across two cache lines.
  struct alignas(64) CacheLine {
    double values[8];
  };

  std::vector<CacheLine> memory_[4]; ///< of sums, velocities, rates and strain rates
  std::vector<CellSums> cell_memory_;
  std::vector<double> mark_memory_;
  std::vector<CellRate> layers_[2];
  NodeSums *sums_ = nullptr;
  double *velocity_ = nullptr, *rates_ = nullptr, *strain_rates_ = nullptr;
  CellSums *cells_ = nullptr;
  double *marks_ = nullptr;
  std::ptrdiff_t velocity_size_ = 0, rates_size_ = 0; ///< doubles of a node
  int cell_size_ = 0;                                 ///< materials that a cell has sums of
  UnitHandle sums_unit_, velocity_unit_;
};

} // namespace mlgimp
