// Sets of values are bits, put together over ranks by words of 31: what a PetscInt holds in every build.
#include "tools/bindings/petsc/label_sets.h"

#include <petscsf.h>

#include <algorithm>
#include <cstddef>

namespace weft::petsc {
namespace {

constexpr std::size_t kBits = 31;

/// One bit for each value.
using Words = std::vector<PetscInt>;

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

/// All ranks: gives the sets of any rank references that are no values.
PetscErrorCode number_sets(MPI_Comm comm, const std::vector<Words>& mine, const std::vector<PetscInt>& values,
                           PetscInt none, std::map<Words, std::int32_t>& refs) {
  IS here = nullptr, everywhere = nullptr;
  PetscInt count = 0;
  const PetscInt* words = nullptr;
  PetscFunctionBegin;
  std::vector<PetscInt> flat;
  for (const Words& set : mine) flat.insert(flat.end(), set.begin(), set.end());
  PetscCall(ISCreateGeneral(comm, static_cast<PetscInt>(flat.size()), flat.data(), PETSC_COPY_VALUES, &here));
  PetscCall(ISAllGather(here, &everywhere));
  PetscCall(ISGetLocalSize(everywhere, &count));
  PetscCall(ISGetIndices(everywhere, &words));
  const auto width = static_cast<PetscInt>((values.size() + kBits - 1) / kBits);
  for (PetscInt at = 0; at < count; at += width) refs[Words(words + at, words + at + width)] = 0;
  PetscCall(ISRestoreIndices(everywhere, &words));
  PetscCall(ISDestroy(&here));
  PetscCall(ISDestroy(&everywhere));
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
  std::vector<Words> of_points(refs.size(), Words(width));
  for (std::size_t word = 0; word < width; ++word) {
    std::vector<PetscInt> marks(static_cast<std::size_t>(chart), 0);
    for (std::size_t i = word * kBits; i < std::min(values.size(), (word + 1) * kBits); ++i)
      PetscCall(mark_points(label, values[i], PetscInt(1) << (i % kBits), marks));
    PetscCall(combine_shared(dm, MPI_BOR, marks));
    for (std::size_t p = 0; p < refs.size(); ++p)
      of_points[p][word] = marks[static_cast<std::size_t>(start) + p];
  }
  std::map<Words, std::int32_t> several;
  std::vector<Words> mine;
  for (std::size_t p = 0; p < refs.size(); ++p) {
    const std::vector<PetscInt> of_point = values_in(of_points[p], values);
    if (of_point.size() == 1) refs[p] = static_cast<std::int32_t>(of_point[0]);
    if (of_point.size() > 1 && several.emplace(of_points[p], 0).second) mine.push_back(of_points[p]);
  }
  PetscCall(number_sets(PetscObjectComm(reinterpret_cast<PetscObject>(dm)), mine, values, none, several));
  for (const auto& [set, ref] : several) sets[ref] = values_in(set, values);
  for (std::size_t p = 0; p < refs.size(); ++p)
    if (const auto known = several.find(of_points[p]); known != several.end()) refs[p] = known->second;
  PetscFunctionReturn(0);
}

std::vector<PetscInt> values_of(const LabelSets& sets, std::int32_t ref) {
  const auto several = sets.find(ref);
  return several == sets.end() ? std::vector<PetscInt>{ref} : several->second;
}

}  // namespace weft::petsc
