// Sets of values are bits, put together over ranks by words of 31: what a PetscInt holds in every build.
#include "tools/bindings/petsc/label_sets.h"

#include <petscsf.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <span>

namespace weft::petsc {
namespace {

constexpr std::size_t kBits = 31;

/// One bit for each value.
using Words = std::vector<PetscInt>;

Words words_of(std::span<const PetscInt> set) { return {set.begin(), set.end()}; }

std::size_t count_bits(std::span<const PetscInt> set) {
  std::size_t count = 0;
  for (const PetscInt word : set)
    count += static_cast<std::size_t>(std::popcount(static_cast<std::uint64_t>(word)));
  return count;
}

/// Of a set that is not empty.
std::size_t first_bit(std::span<const PetscInt> set) {
  std::size_t word = 0;
  while (set[word] == 0) ++word;
  return word * kBits + static_cast<std::size_t>(std::countr_zero(static_cast<std::uint64_t>(set[word])));
}

/// All ranks: the numbers of all ranks, one rank's after the other's.
PetscErrorCode gather(MPI_Comm comm, const std::vector<PetscInt>& mine, std::vector<PetscInt>& all) {
  IS here = nullptr, everywhere = nullptr;
  PetscInt count = 0;
  const PetscInt* values = nullptr;
  PetscFunctionBegin;
  PetscCall(ISCreateGeneral(comm, static_cast<PetscInt>(mine.size()), mine.data(), PETSC_COPY_VALUES, &here));
  PetscCall(ISAllGather(here, &everywhere));
  PetscCall(ISGetLocalSize(everywhere, &count));
  PetscCall(ISGetIndices(everywhere, &values));
  all.assign(values, values + count);
  PetscCall(ISRestoreIndices(everywhere, &values));
  PetscCall(ISDestroy(&here));
  PetscCall(ISDestroy(&everywhere));
  PetscFunctionReturn(0);
}

PetscErrorCode values_of_label(DM dm, DMLabel label, std::vector<PetscInt>& all) {
  IS here = nullptr;
  PetscInt count = 0;
  const PetscInt* values = nullptr;
  PetscFunctionBegin;
  PetscCall(DMLabelGetValueIS(label, &here));
  PetscCall(ISGetLocalSize(here, &count));
  PetscCall(ISGetIndices(here, &values));
  const std::vector<PetscInt> mine(values, values + count);
  PetscCall(ISRestoreIndices(here, &values));
  PetscCall(ISDestroy(&here));
  PetscCall(gather_values(PetscObjectComm(reinterpret_cast<PetscObject>(dm)), mine, all));
  PetscFunctionReturn(0);
}

/// Sets the bit at all points that have the value.
PetscErrorCode mark_points(DMLabel label, PetscInt value, PetscInt bit, std::vector<PetscInt>& marks) {
  IS points = nullptr;
  PetscInt count = 0;
  const PetscInt* at = nullptr;
  PetscFunctionBegin;
  PetscCall(DMLabelGetStratumIS(label, value, &points));
  if (!points) PetscFunctionReturn(0);
  PetscCall(ISGetLocalSize(points, &count));
  PetscCall(ISGetIndices(points, &at));
  for (PetscInt i = 0; i < count; ++i) marks[static_cast<std::size_t>(at[i])] |= bit;
  PetscCall(ISRestoreIndices(points, &at));
  PetscCall(ISDestroy(&points));
  PetscFunctionReturn(0);
}

std::vector<PetscInt> values_in(const Words& words, const std::vector<PetscInt>& all) {
  std::vector<PetscInt> values;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (words[i / kBits] >> (i % kBits) & 1) values.push_back(all[i]);
  return values;
}

/// All ranks: gives the sets of all ranks, `refs` of this one, references that are no values.
PetscErrorCode number_sets(MPI_Comm comm, const std::vector<PetscInt>& values, PetscInt none,
                           std::map<Words, std::int32_t>& refs) {
  PetscFunctionBegin;
  std::vector<PetscInt> mine, all;
  for (const auto& [set, ref] : refs) mine.insert(mine.end(), set.begin(), set.end());
  PetscCall(gather(comm, mine, all));
  const auto width = static_cast<std::ptrdiff_t>((values.size() + kBits - 1) / kBits);
  for (auto at = all.begin(); at != all.end(); at += width) refs[Words(at, at + width)] = 0;
  std::int32_t next = 0;
  for (auto& [set, ref] : refs) {
    while (next == none || std::binary_search(values.begin(), values.end(), next)) ++next;
    ref = next++;
  }
  PetscFunctionReturn(0);
}

}  // namespace

PetscErrorCode combine_shared(DM dm, MPI_Op op, std::vector<PetscInt>& values) {
  PetscSF sf = nullptr;
  PetscInt roots = -1;
  PetscFunctionBegin;
  PetscCall(DMGetPointSF(dm, &sf));
  PetscCall(PetscSFGetGraph(sf, &roots, nullptr, nullptr, nullptr));
  if (roots < 0) PetscFunctionReturn(0);
  std::vector<PetscInt> together = values;
  PetscCall(PetscSFReduceBegin(sf, MPIU_INT, values.data(), together.data(), op));
  PetscCall(PetscSFReduceEnd(sf, MPIU_INT, values.data(), together.data(), op));
  values = together;
  PetscCall(PetscSFBcastBegin(sf, MPIU_INT, together.data(), values.data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(sf, MPIU_INT, together.data(), values.data(), MPI_REPLACE));
  PetscFunctionReturn(0);
}

PetscErrorCode gather_values(MPI_Comm comm, const std::vector<PetscInt>& mine, std::vector<PetscInt>& all) {
  PetscFunctionBegin;
  PetscCall(gather(comm, mine, all));
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  PetscFunctionReturn(0);
}

PetscErrorCode references_of(DM dm, DMLabel label, PetscInt start, PetscInt end, PetscInt none,
                             std::vector<std::int32_t>& refs, LabelSets& sets) {
  PetscInt first = 0, chart = 0;
  std::vector<PetscInt> values;
  PetscFunctionBegin;
  refs.assign(static_cast<std::size_t>(end - start), static_cast<std::int32_t>(none));
  sets.clear();
  if (!label) PetscFunctionReturn(0);
  PetscCall(DMPlexGetChart(dm, &first, &chart));
  PetscCall(values_of_label(dm, label, values));
  const std::size_t width = (values.size() + kBits - 1) / kBits;
  std::vector<PetscInt> bits(width * refs.size());
  for (std::size_t word = 0; word < width; ++word) {
    std::vector<PetscInt> marks(static_cast<std::size_t>(chart), 0);
    for (std::size_t i = word * kBits; i < std::min(values.size(), (word + 1) * kBits); ++i)
      PetscCall(mark_points(label, values[i], PetscInt(1) << (i % kBits), marks));
    PetscCall(combine_shared(dm, MPI_BOR, marks));
    for (std::size_t p = 0; p < refs.size(); ++p)
      bits[p * width + word] = marks[static_cast<std::size_t>(start) + p];
  }
  const auto set_of = [&](std::size_t p) { return std::span(bits).subspan(p * width, width); };
  std::map<Words, std::int32_t> several;
  std::vector<std::size_t> with_several;
  for (std::size_t p = 0; p < refs.size(); ++p) {
    const std::size_t count = count_bits(set_of(p));
    if (count == 1) refs[p] = static_cast<std::int32_t>(values[first_bit(set_of(p))]);
    if (count < 2) continue;
    with_several.push_back(p);
    several[words_of(set_of(p))] = 0;
  }
  PetscCall(number_sets(PetscObjectComm(reinterpret_cast<PetscObject>(dm)), values, none, several));
  for (const auto& [set, ref] : several) sets[ref] = values_in(set, values);
  for (const std::size_t p : with_several) refs[p] = several.at(words_of(set_of(p)));
  PetscFunctionReturn(0);
}

std::vector<PetscInt> values_of(const LabelSets& sets, std::int32_t ref) {
  const auto several = sets.find(ref);
  return several == sets.end() ? std::vector<PetscInt>{ref} : several->second;
}

}  // namespace weft::petsc
