// Patches of the surface to the levels and ranks in whose part of the domain they are.
#include "hierarchy/surface_owners.hpp"

#include "base/exchange.hpp"
#include "hierarchy/transfer/point_transfer.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

struct PlacedPatch {
  SurfacePatch patch;
  int level;
  PetscMPIInt rank;
};

} // namespace

PetscErrorCode SurfaceOwners::Seed(const std::vector<Seeding> &seedings, Vec3 tip)
{
  PetscFunctionBeginUser;
  const auto split = [&] {
    for (int l = 0; l < Levels(); ++l) Split(l, tip);
  };
  for (int l = 0; l < Levels(); ++l) seedings[l].AddPatches(levels_[l]->Mesh().Nodes(), &levels_[l]->Contact().Patches());
  split();
  for (int l = 0; l < Levels(); ++l) { // each time what is short enough of a level comes to the next one
    PetscCall(Assign(true, Levels()));
    split();
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The level that the points there belong to, where those of level `now` come from.
int SurfaceOwners::LevelAt(Vec3 x, int now, int active) const
{
  int l = 0;
  for (int finer = 1; finer < active; ++finer) {
    const LevelGeometry &level = levels_[finer]->Geometry();
    if (!WidenedBox(level, (finer > now ? kEnter : kLeave) * level.grid.spacing).Contains(x)) break;
    l = finer;
  }
  return l;
}

/// Sends patches to the owners of the nodes nearest to them, and where asked for to other levels.
PetscErrorCode SurfaceOwners::Assign(bool to_levels, int active)
{
  const PetscMPIInt own = RankIn(comm_);
  const int dim = levels_[0]->Geometry().grid.dim;
  std::vector<PlacedPatch> moved;
  PetscFunctionBeginUser;
  for (int l = 0; l < Levels(); ++l) {
    std::vector<SurfacePatch> &patches = levels_[l]->Contact().Patches().Patches(), stay;
    for (const SurfacePatch &patch : patches) {
      const Vec3 x = patch.Center(dim);
      const int level = to_levels ? LevelAt(x, l, active) : l;
      const NodePartition &nodes = levels_[level]->Mesh().Nodes();
      const PetscMPIInt rank = nodes.OwnerOf(nodes.Geometry().Nearest(x));
      if (level == l && rank == own)
        stay.push_back(patch);
      else
        moved.push_back({patch, level, rank});
    }
    patches = std::move(stay);
  }
  PetscCall(ExchangeRecords(comm_, &moved, [](const PlacedPatch &one) { return one.rank; }));
  for (const PlacedPatch &one : moved) levels_[one.level]->Contact().Patches().Add(one.patch);
  for (auto &level : levels_) level->Contact().Patches().NumberCorners(dim);
  if (to_levels) drift_ = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void SurfaceOwners::Split(int l, Vec3 tip)
{
  const LevelParts level = levels_[l]->Parts();
  levels_[l]->Contact().Patches().Split(level.model.geometry, *level.model.indenter, tip, level.geometry.grid.spacing);
}

PetscErrorCode SurfaceOwners::Watch(int active, int owner_changes)
{
  constexpr double kMaxDrift = 0.5; // cells
  double drift = 0;
  PetscFunctionBeginUser;
  if (owner_changes_ != owner_changes || drift_ > kMaxDrift) PetscCall(Assign(drift_ > kMaxDrift, active));
  owner_changes_ = owner_changes;
  for (int l = 0; l < Levels(); ++l) drift = std::max(drift, std::pow(ratio_, l) * levels_[l]->Stores().Drift().per_step);
  drift_ += drift;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SurfaceOwners::Gather(int l, std::vector<double> *numbers) const
{
  std::vector<SurfacePatch> patches = levels_[l]->Contact().Patches().Patches();
  PetscFunctionBeginUser;
  PetscCall(ExchangeRecords(comm_, &patches, [](const SurfacePatch &) { return 0; }));
  std::sort(patches.begin(), patches.end());
  numbers->clear();
  for (const SurfacePatch &patch : patches) {
    numbers->insert(numbers->end(), {static_cast<double>(patch.number), double(patch.path), double(patch.body)});
    for (const Vec3 &corner : patch.corner) numbers->insert(numbers->end(), corner.begin(), corner.end());
    numbers->insert(numbers->end(), {patch.ring, patch.flow});
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SurfaceOwners::Restore(int l, const std::vector<double> &numbers)
{
  std::vector<SurfacePatch> &patches = levels_[l]->Contact().Patches().Patches();
  PetscFunctionBeginUser;
  patches.clear();
  for (std::size_t k = 0; RankIn(comm_) == 0 && k + kOfPatch <= numbers.size(); k += kOfPatch) {
    const double *n = &numbers[k];
    SurfacePatch &patch = patches.emplace_back();
    patch.number = static_cast<std::int64_t>(n[0]), patch.path = static_cast<std::int64_t>(n[1]),
    patch.body = static_cast<int>(n[2]);
    n += 3;
    for (Vec3 &corner : patch.corner) std::copy_n(n, 3, corner.begin()), n += 3;
    patch.ring = n[0], patch.flow = n[1];
  }
  PetscCall(Assign(false, Levels()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
