// Where two levels meet, from places alone: how far a fine node is its own, and the coarse nodes that move with fine ones.
//
// Nested grids give N_I = sum_i N_I(x_i) N_i for a coarse hat N_I and the fine hats N_i. With beta_i in [0, 1], which grows
// from zero outside the fine level's box to one at depth W h inside, the functions beta_i N_i and
// sum_i (1 - beta_i) N_I(x_i) N_i add up to one. The coarse nodes of the second kind are the interface nodes, the fine nodes
// with beta < 1 are the band, those with beta = 0 are constrained. See docs/levels.md.
#pragma once

#include "contact/border_nodes.hpp"
#include "level/level_geometry.hpp"

#include <cstddef>

namespace mlgimp
{

/// Width of the band inside a border, cells of the coarser level: where boxes leave room, and at the least.
inline constexpr double kBlendWidth = 4, kMinBlendWidth = 2;
/// Cells beside the band that a border needs free of other borders and of contact.
inline constexpr double kBorderCells = 3;

class BorderGeometry
{
public:
  BorderGeometry() = default;
  /// blend_width: W, cells of the coarser level.
  BorderGeometry(const GridGeometry &coarse, const LevelGeometry &fine, int ratio, double blend_width)
      : coarse_(coarse), fine_(fine), ratio_(ratio), blend_width_(blend_width)
  {
  }
  int Dim() const { return fine_.grid.dim; }
  int Ratio() const { return ratio_; }

  /// The part of a fine node's motion that is its own.
  double Beta(Index node) const;
  /// Beta of a fine node, and its weights N_I(x_i) on coarse nodes.
  NodeBlend BlendOf(Index node) const;
  /// The fine nodes that can bear mass: beyond a side of the domain that is the first layer only.
  IndexBox MassNodes() const;
  /// Indices of the fine box's lower corner on the coarse grid.
  Index Offset() const;
  /// The fine node at the place of a coarse one, or the nearest to it.
  Index FineNodeAt(Index coarse) const;

  /// True where some fine node with beta < 1 lies within the hat of a coarse node.
  bool IsInterface(Index node) const;
  /// The coarse nodes among which interface nodes are.
  IndexBox Around() const;
  /// Calls work(index) for the interface nodes in a box, the first axis fastest.
  template <class Work> void ForEachInterface(const IndexBox &box, Work work) const
  {
    ForEach(Intersection(box, Around()), [&](Index node) {
      if (IsInterface(node)) work(node);
    });
  }
  /// Number of interface nodes.
  std::size_t Count() const;

private:
  int Depth(Index node) const;

  GridGeometry coarse_{};
  LevelGeometry fine_{};
  int ratio_ = 2;
  double blend_width_ = kBlendWidth;
};

} // namespace mlgimp
