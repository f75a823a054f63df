// Patches of the surface to the levels and ranks in whose part of the domain they are.
#include "hierarchy/hierarchy.hpp"

#include "base/exchange.hpp"

#include <algorithm>

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

PetscErrorCode Hierarchy::SeedSurface(const std::vector<Seeding> &seedings)
{
  PetscFunctionBeginUser;
  const auto split = [&] {
    for (auto &level : levels_) level->SplitSurface(tip_.At(0));
  };
  for (int l = 0; l < Levels(); ++l) seedings[l].AddPatches(levels_[l]->Mesh(), &levels_[l]->Contact().Patches());
  split();
  for (int l = 0; l < Levels(); ++l) { // each time what is short enough of a level comes to the next one
    PetscCall(AssignPatches(true));
    split();
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The level that the points there belong to, where those of level `now` come from.
int Hierarchy::LevelAt(Vec3 x, int now) const
{
  int l = 0;
  for (int finer = 1; finer < Levels() && IsActive(finer); ++finer) {
    const LevelGeometry &level = levels_[finer]->Geometry();
    if (!WidenedBox(level, (finer > now ? kEnter : kLeave) * level.grid.spacing).Contains(x)) break;
    l = finer;
  }
  return l;
}

/// Sends patches to the owners of the nodes nearest to them, and where asked for to other levels.
PetscErrorCode Hierarchy::AssignPatches(bool to_levels)
{
  const PetscMPIInt own = RankIn(comm_);
  const int dim = settings_.levels[0].grid.dim;
  std::vector<PlacedPatch> moved;
  PetscFunctionBeginUser;
  for (int l = 0; l < Levels(); ++l) {
    std::vector<SurfacePatch> &patches = levels_[l]->Contact().Patches().Patches(), stay;
    for (const SurfacePatch &patch : patches) {
      const Vec3 x = patch.Center(dim);
      const int level = to_levels ? LevelAt(x, l) : l;
      const Grid &grid = levels_[level]->Mesh();
      const PetscMPIInt rank = grid.OwnerOfNode(grid.Nearest(x));
      if (level == l && rank == own)
        stay.push_back(patch);
      else
        moved.push_back({patch, level, rank});
    }
    patches = std::move(stay);
    levels_[l]->TakePatchesDue();
  }
  PetscCall(ExchangeRecords(comm_, &moved, [](const PlacedPatch &one) { return one.rank; }));
  for (const PlacedPatch &one : moved) levels_[one.level]->Contact().Patches().Add(one.patch);
  for (auto &level : levels_) level->Contact().Patches().NumberCorners(dim);
  if (to_levels) patch_drift_ = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Hierarchy::GatherPatches(int l, std::vector<double> *numbers) const
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

PetscErrorCode Hierarchy::RestorePatches(int l, const std::vector<double> &numbers)
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
  PetscCall(AssignPatches(false));
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
