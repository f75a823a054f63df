// Gathering, solving and applying the contact equations.
#include "level/contact_system.hpp"

#include <algorithm>
#include <cmath>

namespace mlgimp
{

namespace
{

/// What a rank sends for a row, an entry (with the node's state, which every holder of the node knows).
struct RowRecord {
  double key, weight, gap, x, left, right;
};
struct EntryRecord {
  double key, node, test[2], force[2], inverse_mass[2], velocity[2];
};

/// What the root sends back: a header, then (key, pressure) pairs and (i, j, dv) quadruples.
struct Header {
  double pressures, nodes, impulse[2], side_impulse[2], half_width, peak_pressure, set_updates, fallback, solved;
};
constexpr int kHeaderSize = sizeof(Header) / sizeof(double);

/// Adds plain records of doubles to the end of an array of doubles.
template <class Record> void AppendRecords(const std::vector<Record> &records, std::vector<double> &doubles)
{
  const double *first = reinterpret_cast<const double *>(records.data());
  doubles.insert(doubles.end(), first, first + records.size() * (sizeof(Record) / sizeof(double)));
}

/// Takes `count` records from the front of `doubles`, which moves on.
template <class Record> void TakeRecords(const double *&doubles, int count, std::vector<Record> &records)
{
  const Record *first = reinterpret_cast<const Record *>(doubles);
  records.insert(records.end(), first, first + count);
  doubles += count * (sizeof(Record) / sizeof(double));
}

/// Sorts records by `less` and adds up those that it finds equal.
template <class Record, class Less, class Add> void Merge(std::vector<Record> &records, Less less, Add add)
{
  std::stable_sort(records.begin(), records.end(), less);
  std::size_t kept = 0;
  for (std::size_t k = 1; k < records.size(); ++k) {
    if (less(records[kept], records[k]))
      records[++kept] = records[k];
    else
      add(records[kept], records[k]);
  }
  if (!records.empty()) records.resize(kept + 1);
}

/// Where a contact ends, from the pressures p of the five outermost unknowns, `spacing` apart, the second at distance d.
/// At a smooth edge p^2 = B t (1 + g t), t = a - x (g = -1/2a under a cylinder, positive under a wedge). As single
/// pressures scatter at the edge, the last four enter by their integral only; the first two fix g. Where p does not
/// fall, or this leads beyond `limit`, an edge of the indenter ends the contact.
double ContactEdge(double d, double spacing, const double p[5], double limit)
{
  if (p[1] >= p[0]) return limit;
  const double tail = spacing * (0.5 * p[1] + p[2] + p[3] + p[4]) / p[1], fall = (p[0] / p[1]) * (p[0] / p[1]);
  double e = 1.5 * tail; // a - d
  for (int iteration = 0; iteration < 20; ++iteration) {
    const double s = fall * e / (e + spacing);
    const double ge = std::clamp((1 - s) * e / (s * e - (e + spacing)), -0.4, 1.0);
    e = tail * std::sqrt(1 + ge) / (2.0 / 3 + ge / 5);
  }
  return std::min(limit, d + e);
}

} // namespace

/// The gathered problem on the root.
struct ContactSystem::Problem {
  std::vector<RowRecord> rows;
  std::vector<EntryRecord> entries; ///< those of one node stand together
  std::vector<int> unknown;         ///< number of each entry's unknown, or -1 where it was left out

  /// The parts of all ranks on the first one; nothing on others. Collective.
  PetscErrorCode Gather(MPI_Comm comm, Problem *all) const;
  void Assemble(double dt, double diagonal_shift, BandMatrix *A, std::vector<double> *r) const;
  std::vector<double> Answer(double dt, const std::vector<double> &lambda, Header header) const;

  /// Calls work(first, end) for the range of entries of each node.
  template <class Work> void ForEachNode(Work work) const
  {
    const int count = static_cast<int>(entries.size());
    for (int first = 0, end; first < count; first = end) {
      for (end = first; end < count && entries[end].node == entries[first].node;) ++end;
      work(first, end);
    }
  }

  void MergeRanks()
  {
    Merge(
        rows, [](const RowRecord &a, const RowRecord &b) { return a.key < b.key; },
        [](RowRecord &a, const RowRecord &b) {
          a.weight += b.weight;
          a.gap += b.gap;
          a.left = std::min(a.left, b.left);
          a.right = std::max(a.right, b.right);
        });
    Merge(
        entries, [](const EntryRecord &a, const EntryRecord &b) { return a.node != b.node ? a.node < b.node : a.key < b.key; },
        [](EntryRecord &a, const EntryRecord &b) {
          for (int d = 0; d < 2; ++d) a.test[d] += b.test[d], a.force[d] += b.force[d];
        });
  }

  /// Leaves out weak unknowns and those that reach no mass; numbers the rest. Needs rows in the order of their keys.
  void NumberUnknowns(double drop_below)
  {
    const auto before = [](const RowRecord &row, double key) { return row.key < key; };
    std::vector<int> number(rows.size(), -1);
    std::vector<char> reaches_mass(rows.size(), 0);
    unknown.clear();
    for (const EntryRecord &e : entries) {
      unknown.push_back(static_cast<int>(std::lower_bound(rows.begin(), rows.end(), e.key, before) - rows.begin()));
      reaches_mass[unknown.back()] = 1;
    }
    int kept = 0;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (rows[k].weight < drop_below || !reaches_mass[k]) continue;
      number[k] = kept;
      rows[kept++] = rows[k];
    }
    rows.resize(kept);
    for (int &row : unknown) row = number[row];
  }

  /// Half the width of the part under pressure; where it lies on one side of the tip, all of its width.
  double HalfWidth(const std::vector<double> &lambda, bool smooth, double tip, double rounding) const
  {
    double reach[2] = {0, 0}; // to the left and to the right of the tip; what lies at the tip counts on both sides
    for (int side = 0; side < 2; ++side) {
      const double sign = side ? 1 : -1;
      std::vector<std::pair<double, int>> loaded; // by distance from the tip
      for (int k = 0; k < static_cast<int>(rows.size()); ++k)
        if (lambda[k] > 0 && sign * (rows[k].x - tip) >= -rounding) loaded.push_back({sign * (rows[k].x - tip), k});
      if (loaded.empty()) continue;
      std::sort(loaded.begin(), loaded.end());
      const std::size_t n = loaded.size();
      const RowRecord &last = rows[loaded.back().second];
      reach[side] = std::max(0.0, sign * ((side ? last.right : last.left) - tip));
      if (smooth && n >= 5) {
        double pressure[5];
        for (std::size_t k = 0; k < 5; ++k) pressure[k] = lambda[loaded[n - 5 + k].second];
        reach[side] = ContactEdge(loaded[n - 4].first, loaded[n - 4].first - loaded[n - 5].first, pressure, reach[side]);
      }
    }
    const bool both_sides = std::min(reach[0], reach[1]) > 0.05 * std::max(reach[0], reach[1]);
    return both_sides ? 0.5 * (reach[0] + reach[1]) : std::max(reach[0], reach[1]);
  }
};

PetscErrorCode ContactSystem::Create(bool symmetric, double diagonal_shift, bool monitor)
{
  PetscFunctionBeginUser;
  symmetric_ = symmetric;
  diagonal_shift_ = diagonal_shift;
  PetscCall(solver_.Create(symmetric));
  monitor_ = monitor;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A_jk = dt^2 sum_i test_ij . force_ik/m_i and r_j = -gap_j - dt sum_i test_ij . v_i.
void ContactSystem::Problem::Assemble(double dt, double diagonal_shift, BandMatrix *A, std::vector<double> *r) const
{
  const int n = static_cast<int>(rows.size());
  int reach = 0;
  ForEachNode([&](int first, int end) {
    int low = n, high = -1;
    for (int e = first; e < end; ++e)
      if (unknown[e] >= 0) low = std::min(low, unknown[e]), high = std::max(high, unknown[e]);
    reach = std::max(reach, high - low);
  });
  A->Reset(n, reach);
  r->resize(n);
  for (int k = 0; k < n; ++k) (*r)[k] = -rows[k].gap;
  ForEachNode([&](int first, int end) {
    for (int a = first; a < end; ++a) {
      if (unknown[a] < 0) continue;
      const EntryRecord &row = entries[a];
      (*r)[unknown[a]] -= dt * (row.test[0] * row.velocity[0] + row.test[1] * row.velocity[1]);
      for (int b = first; b < end; ++b)
        if (unknown[b] >= 0)
          A->At(unknown[a], unknown[b]) +=
              dt * dt *
              (row.test[0] * entries[b].force[0] * row.inverse_mass[0] + row.test[1] * entries[b].force[1] * row.inverse_mass[1]);
    }
  });
  for (int k = 0; k < n; ++k) A->At(k, k) *= 1 + diagonal_shift;
}

/// The answer to all ranks: header, pressures, changes of nodal velocities.
std::vector<double> ContactSystem::Problem::Answer(double dt, const std::vector<double> &lambda, Header header) const
{
  std::vector<double> answer(kHeaderSize);
  for (std::size_t k = 0; k < rows.size(); ++k)
    if (lambda[k] > 0) {
      answer.insert(answer.end(), {rows[k].key, lambda[k]});
      ++header.pressures;
    }
  ForEachNode([&](int first, int end) {
    const EntryRecord &node = entries[first];
    Vec3 impulse{};
    for (int e = first; e < end; ++e)
      if (unknown[e] >= 0)
        for (int d = 0; d < 2; ++d) impulse[d] += dt * entries[e].force[d] * lambda[unknown[e]];
    if (impulse[0] == 0 && impulse[1] == 0) return;
    answer.insert(answer.end(), {node.node, impulse[0] * node.inverse_mass[0], impulse[1] * node.inverse_mass[1]});
    ++header.nodes;
    for (int d = 0; d < 2; ++d) {
      header.impulse[d] += impulse[d];
      if (node.inverse_mass[d] == 0) header.side_impulse[d] -= impulse[d];
    }
  });
  std::copy_n(reinterpret_cast<const double *>(&header), kHeaderSize, answer.begin());
  return answer;
}

PetscErrorCode ContactSystem::Problem::Gather(MPI_Comm comm, Problem *all) const
{
  PetscMPIInt rank, size;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  const int sources = rank == 0 ? size : 0, counts[2] = {static_cast<int>(rows.size()), static_cast<int>(entries.size())};
  std::vector<int> all_counts(2 * sources), lengths(sources), offsets(sources);
  PetscCallMPI(MPI_Gather(counts, 2, MPI_INT, all_counts.data(), 2, MPI_INT, 0, comm));
  int total = 0;
  for (int k = 0; k < sources; ++k) {
    lengths[k] = (all_counts[2 * k] * sizeof(RowRecord) + all_counts[2 * k + 1] * sizeof(EntryRecord)) / sizeof(double);
    offsets[k] = total;
    total += lengths[k];
  }
  std::vector<double> mine, received(total);
  AppendRecords(rows, mine);
  AppendRecords(entries, mine);
  PetscCallMPI(MPI_Gatherv(mine.data(), static_cast<int>(mine.size()), MPI_DOUBLE, received.data(), lengths.data(),
                           offsets.data(), MPI_DOUBLE, 0, comm));
  const double *next = received.data();
  for (int k = 0; k < sources; ++k) {
    TakeRecords(next, all_counts[2 * k], all->rows);
    TakeRecords(next, all_counts[2 * k + 1], all->entries);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactSystem::SolveOnRoot(const ContactView &view, Problem &problem, double drop_below,
                                          std::vector<double> *answer)
{
  BandMatrix A;
  ActiveSetReport report;
  Header header{};
  std::vector<double> r, lambda;
  PetscFunctionBeginUser;
  problem.NumberUnknowns(drop_below);
  problem.Assemble(view.dt, diagonal_shift_, &A, &r);
  for (const RowRecord &row : problem.rows) {
    auto previous = pressures_.find(static_cast<std::int64_t>(row.key));
    lambda.push_back(previous == pressures_.end() ? 0 : previous->second);
  }
  PetscCall(solver_.Solve(A, r, lambda, &report));
  const double rounding = 1e-6 * view.grid.Geometry().spacing;
  header.half_width = problem.HalfWidth(lambda, symmetric_, view.indenter.Tip(view.time)[0], rounding);
  for (double pressure : lambda) header.peak_pressure = std::max(header.peak_pressure, pressure);
  header.set_updates = report.set_updates;
  header.fallback = report.fallback;
  header.solved = report.solved;
  *answer = problem.Answer(view.dt, lambda, header);
  if (monitor_ && report.active)
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "contact: time %.6e unknowns %d active %d set updates %d iterations %d\n", view.time,
                          A.size, report.active, report.set_updates, report.linear_iterations));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactSystem::Solve(const ContactView &view, const std::vector<ContactRow> &rows,
                                    const std::vector<ContactEntry> &entries, double drop_below, ContactReport *report)
{
  const Grid &grid = view.grid;
  const int width = grid.Geometry().Nodes(0), padding = grid.Geometry().padding;
  PetscMPIInt rank, ranks;
  Problem problem;
  std::vector<RowRecord> my_rows;
  std::vector<EntryRecord> my_entries;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(grid.Comm(), &rank));
  PetscCallMPI(MPI_Comm_size(grid.Comm(), &ranks));
  for (const ContactRow &row : rows)
    my_rows.push_back({static_cast<double>(row.key), row.weight, row.gap, row.x, row.left, row.right});
  for (const ContactEntry &e : entries) {
    const Index node = {e.i, e.j, 0};
    const double mass = grid.Sums()[grid.Place(node)].mass, *velocity = grid.Velocity(grid.Place(node)).velocity;
    if (mass <= view.mass_cutoff) continue;
    my_entries.push_back({static_cast<double>(e.key),
                          static_cast<double>(e.j + padding) * width + e.i + padding,
                          {e.test[0], e.test[1]},
                          {e.force[0], e.force[1]},
                          {view.sides.Constrains(node, 0) ? 0 : 1 / mass, view.sides.Constrains(node, 1) ? 0 : 1 / mass},
                          {velocity[0], velocity[1]}});
  }
  Problem mine{std::move(my_rows), std::move(my_entries), {}};
  mine.MergeRanks();
  PetscCall(mine.Gather(grid.Comm(), &problem));

  std::vector<double> answer;
  if (rank == 0) {
    if (ranks > 1) problem.MergeRanks();
    PetscCall(SolveOnRoot(view, problem, drop_below, &answer));
  }
  int size = static_cast<int>(answer.size());
  PetscCallMPI(MPI_Bcast(&size, 1, MPI_INT, 0, grid.Comm()));
  answer.resize(size);
  PetscCallMPI(MPI_Bcast(answer.data(), size, MPI_DOUBLE, 0, grid.Comm()));

  Header header;
  std::copy_n(answer.begin(), kHeaderSize, reinterpret_cast<double *>(&header));
  report->impulse = {header.impulse[0], header.impulse[1]};
  report->side_impulse = {header.side_impulse[0], header.side_impulse[1]};
  report->half_width = header.half_width;
  report->peak_pressure = header.peak_pressure;
  report->set_updates = static_cast<int>(header.set_updates);
  report->fallback = header.fallback != 0;
  report->solved = header.solved != 0;
  const double *next = answer.data() + kHeaderSize;
  pressures_.clear();
  for (int k = 0; k < static_cast<int>(header.pressures); ++k, next += 2)
    pressures_[static_cast<std::int64_t>(next[0])] = next[1];
  for (int k = 0; k < static_cast<int>(header.nodes); ++k, next += 3) {
    const std::int64_t node = static_cast<std::int64_t>(next[0]);
    const int i = static_cast<int>(node % width) - padding, j = static_cast<int>(node / width) - padding;
    if (!grid.IsLocal({i, j, 0})) continue;
    ChangeVelocity(view, {i, j, 0}, {next[1], next[2]}, report);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

} // namespace mlgimp
