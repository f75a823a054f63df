// Memory of the nodal arrays.
#include "grid/nodal_arrays.hpp"

#include <algorithm>

namespace mlgimp
{

PetscErrorCode NodalArrays::Create(int dim, std::ptrdiff_t nodes, int volume_averages, bool has_strain_rates)
{
  PetscFunctionBeginUser;
  velocity_size_ = NodeLayout::Velocity(dim);
  rates_size_ = NodeLayout::Rates(dim);
  cell_size_ = volume_averages;
  const std::ptrdiff_t components[4] = {NodeLayout::kSums, velocity_size_, rates_size_, has_strain_rates ? rates_size_ : 0};
  for (int k = 0; k < 4; ++k) memory_[k].assign((nodes * components[k] + 7) / 8, {});
  sums_ = reinterpret_cast<NodeSums *>(memory_[0].data());
  velocity_ = reinterpret_cast<double *>(memory_[1].data());
  rates_ = reinterpret_cast<double *>(memory_[2].data());
  strain_rates_ = has_strain_rates ? reinterpret_cast<double *>(memory_[3].data()) : nullptr;
  cell_memory_.resize(cell_size_ * nodes);
  cells_ = cell_memory_.data();
  mark_memory_.resize(has_strain_rates ? nodes : 0);
  marks_ = has_strain_rates ? mark_memory_.data() : nullptr;
  PetscCall(sums_unit_.Create(NodeLayout::kSums));
  PetscCall(velocity_unit_.Create(static_cast<int>(velocity_size_)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

CellRate *NodalArrays::Layer(int layer, std::ptrdiff_t count)
{
  std::vector<CellRate> &cells = layers_[layer % 2];
  if (static_cast<std::ptrdiff_t>(cells.size()) < count) cells.resize(count);
  return cells.data();
}

void NodalArrays::ClearSums() const
{
  std::fill_n(sums_, memory_[0].size(), NodeSums{});
  std::fill_n(marks_, mark_memory_.size(), 0.0);
}

void NodalArrays::ClearRates() const
{
  std::fill_n(reinterpret_cast<CacheLine *>(rates_), memory_[2].size(), CacheLine{});
  std::fill_n(cells_, cell_memory_.size(), CellSums{});
}

} // namespace mlgimp
