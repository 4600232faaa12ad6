// Fields are agreed upon, sent by ids, and fetched by numbers.
#include "tools/library/parts/part_fields.h"

#include <algorithm>
#include <cstddef>
#include <string>

#include "meshing/base/error.h"
#include "meshing/base/place_in.h"
#include "partition/communication/ranges.h"
#include "partition/fields/by_components.h"
#include "tools/library/parts/part_values.h"

namespace weft::tools {
namespace {

using partition::Peers;

/// All ranks: kinds and names, without values; names are those of the lowest rank that has fields.
Fields agreed_fields(Peers& peers, const Part& part) {
  std::vector<Field::Kind> kinds;
  std::vector<char> names;  // each with a 0 behind it
  for (const Field& field : part.fields.fields) {
    kinds.push_back(field.kind);
    names.insert(names.end(), field.name.begin(), field.name.end());
    names.push_back('\0');
  }
  const auto all_names = partition::allgather(peers, names);
  const auto all_kinds = partition::allgather(peers, kinds);
  const auto has = std::ranges::find_if(all_kinds, [](const auto& of_rank) { return !of_rank.empty(); });
  Fields agreed;
  if (has == all_kinds.end()) return agreed;
  const auto has_points =
      partition::allgather(peers, std::vector<std::uint8_t>{std::uint8_t{!part.mesh.points.empty()}});
  for (std::size_t r = 0; r < all_kinds.size(); ++r)
    if ((has_points[r][0] || !all_kinds[r].empty()) && all_kinds[r] != *has)
      throw InputError("", "fields", "are not of the same number and kinds on all ranks");
  const char* name = all_names[static_cast<std::size_t>(has - all_kinds.begin())].data();
  for (const Field::Kind kind : *has) {
    agreed.fields.push_back({kind, {}, name});
    name += agreed.fields.back().name.size() + 1;
  }
  return agreed;
}

}  // namespace

Fields fields_of_slices(Peers& peers, const Part& part) {
  Fields fields = agreed_fields(peers, part);
  if (fields.fields.empty()) return fields;
  for (std::size_t f = 0; f < part.fields.fields.size(); ++f)
    fields.fields[f].values = part.fields.fields[f].values;
  const IdHomes homes(peers, largest_id(part.ids));
  std::size_t points = 0;
  fields = partition::by_components(fields, 0, [&](const std::vector<double>& column) {
    std::string ignored;  // copies that were computed apart may differ by rounding
    std::vector<double> values = values_of_slice(peers, homes, part.ids, column, ignored);
    points = values.size();
    return values;
  });
  fields.num_points = points;
  return fields;
}

Fields fields_at(Peers& peers, const partition::MeshSlice& slice, const Fields& of_slice,
                 const std::vector<std::uint64_t>& numbers) {
  std::vector<std::uint64_t> wanted = numbers;
  std::ranges::sort(wanted);
  const partition::Ranges points(peers, slice.points.size());
  return partition::by_components(of_slice, numbers.size(), [&](const std::vector<double>& column) {
    const std::vector<double> found =
        partition::fetch<double>(peers, points, wanted, [&](std::size_t i) { return column[i]; });
    std::vector<double> values;
    values.reserve(numbers.size());
    for (const std::uint64_t number : numbers) values.push_back(found[meshing::place_in(wanted, number)]);
    return values;
  });
}

}  // namespace weft::tools
