#include "tools/library/parts/part_faces.h"

#include <algorithm>
#include <array>
#include <bit>
#include <compare>
#include <sstream>
#include <string>
#include <utility>

#include "meshing/mesh/tet_tables.h"
#include "partition/communication/agreement.h"

namespace weft::tools {
namespace {

using partition::Peers;
using Key = std::array<std::uint64_t, 3>;

/// A face of a tet, or a triangle (of no tet), by the numbers of its vertices. Plain data.
struct FaceRecord {
  Key key;
  std::uint64_t tet;  ///< 1-based on its rank; 0 for a triangle
};

/// A face that nothing has met, by its place: the bits of its points' coordinates.
struct PlaceRecord {
  std::array<std::uint64_t, 9> place;
  std::uint64_t tet;
};

template <class Record, class Of>
std::vector<std::vector<Record>> to_homes(Peers& peers, const std::vector<Record>& records, const Of& key) {
  std::vector<std::vector<Record>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (const Record& record : records) {
    std::uint64_t hash = 0;
    for (const std::uint64_t part : key(record)) hash = (hash ^ part ^ (part >> 29)) * 0xD6E8FEB86659FD93ull;
    to_each[(hash >> 32) % to_each.size()].push_back(record);
  }
  return partition::all_to_all(peers, to_each);
}

/// Faces of tets that no other tet of this part has, and triangles.
std::vector<FaceRecord> open_faces(const Mesh& mesh, const std::vector<std::uint64_t>& numbers) {
  std::vector<FaceRecord> faces;
  faces.reserve(4 * mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (std::size_t f = 0; f < 4; ++f) {
      Key key{};
      for (std::size_t i = 0, k = 0; i < 4; ++i)
        if (i != f) key[k++] = numbers[mesh.tets[t][i]];
      std::ranges::sort(key);
      faces.push_back({key, t + 1});
    }
  std::ranges::sort(faces, {}, [](const FaceRecord& f) { return std::pair(f.key, f.tet); });
  std::vector<FaceRecord> open;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool pair = i + 1 < faces.size() && faces[i + 1].key == faces[i].key &&
                      !(i + 2 < faces.size() && faces[i + 2].key == faces[i].key);
    if (pair)
      ++i;
    else
      open.push_back(faces[i]);
  }
  for (const auto& triangle : mesh.triangles) {
    Key key{numbers[triangle[0]], numbers[triangle[1]], numbers[triangle[2]]};
    std::ranges::sort(key);
    open.push_back({key, 0});
  }
  return open;
}

struct Met {
  FaceRecord face;
  std::size_t rank, index;
};

std::string tet_name(const Met& met) {
  std::ostringstream out;
  out << "rank " << met.rank << ": tet " << met.face.tet;
  return std::move(out).str();
}

/// What is wrong with the records of one face that met at its home; tets first, then triangles.
enum class Finding : std::uint8_t { good, open, bare, crowded };

Finding judge(std::span<const Met> met, bool triangles_given) {
  const auto tets = std::ranges::count_if(met, [](const Met& m) { return m.face.tet > 0; });
  if (tets > 2) return Finding::crowded;
  if (tets != 1 || static_cast<std::size_t>(tets) < met.size()) return Finding::good;
  return triangles_given ? Finding::bare : Finding::open;
}

/// The bits of the three points, so that equal places are equal keys.
PlaceRecord place_of(const Mesh& mesh, const std::vector<std::uint64_t>& numbers, const FaceRecord& face) {
  const auto& tet = mesh.tets[face.tet - 1];
  std::vector<std::array<std::uint64_t, 3>> points;
  for (const std::uint32_t v : tet) {
    if (std::ranges::find(face.key, numbers[v]) == face.key.end()) continue;
    const Point& p = mesh.points[v];
    points.push_back({std::bit_cast<std::uint64_t>(p.x + 0.0), std::bit_cast<std::uint64_t>(p.y + 0.0),
                      std::bit_cast<std::uint64_t>(p.z + 0.0)});
  }
  std::ranges::sort(points);
  PlaceRecord record{{}, face.tet};
  for (std::size_t i = 0; i < 3; ++i)
    std::ranges::copy(points[i], record.place.begin() + 3 * static_cast<int>(i));
  return record;
}

/// All ranks: two open faces at one place are the two sides of a hole.
void check_places(Peers& peers, const std::vector<PlaceRecord>& mine) {
  const auto arrived = to_homes(peers, mine, [](const PlaceRecord& r) { return r.place; });
  struct Here {
    PlaceRecord record;
    std::size_t rank;
  };
  std::vector<Here> all;
  for (std::size_t r = 0; r < arrived.size(); ++r)
    for (const PlaceRecord& record : arrived[r]) all.push_back({record, r});
  std::ranges::stable_sort(all, {}, [](const Here& h) { return h.record.place; });
  std::string issue;
  for (std::size_t i = 1; i < all.size() && issue.empty(); ++i) {
    if (all[i].record.place != all[i - 1].record.place) continue;
    std::ostringstream out;
    out << "rank " << all[i].rank << ": tet " << all[i].record.tet << ": a face lies on one of tet "
        << all[i - 1].record.tet << " of rank " << all[i - 1].rank
        << ", but their vertices have other ids: a hole between the parts";
    issue = std::move(out).str();
  }
  partition::agree(peers, issue);
}

}  // namespace

void check_faces_of_parts(Peers& peers, const Mesh& mesh, const std::vector<std::uint64_t>& numbers) {
  bool triangles_given = false;
  for (const auto& of_rank : partition::allgather(peers, std::vector<char>{!mesh.triangles.empty()}))
    triangles_given |= of_rank[0] != 0;
  const std::vector<FaceRecord> mine = open_faces(mesh, numbers);
  // Which home a record goes to and in which order it arrives there follows from the record: answers find
  // back by it.
  const auto arrived = to_homes(peers, mine, [](const FaceRecord& r) { return r.key; });
  std::vector<Met> all;
  for (std::size_t r = 0; r < arrived.size(); ++r)
    for (std::size_t i = 0; i < arrived[r].size(); ++i) all.push_back({arrived[r][i], r, i});
  std::ranges::stable_sort(all, {}, [](const Met& m) { return m.face.key; });
  std::string issue;
  std::vector<std::vector<FaceRecord>> open(arrived.size());
  for (std::size_t i = 0, end = 0; i < all.size(); i = end) {
    while (end < all.size() && all[end].face.key == all[i].face.key) ++end;
    const std::span<const Met> met(all.data() + i, end - i);
    const Finding finding = judge(met, triangles_given);
    const Met& tet = *std::ranges::max_element(met, {}, [](const Met& m) { return m.face.tet > 0; });
    if (finding == Finding::open) open[tet.rank].push_back(tet.face);
    if (!issue.empty()) continue;
    if (finding == Finding::crowded) issue = tet_name(tet) + ": has a face that two other tets have too";
    if (finding == Finding::bare)
      issue = tet_name(tet) +
              ": has a face that no other tet and no triangle has, though triangles are given: a hole "
              "between the parts, or a triangle is missing";
  }
  partition::agree(peers, issue);
  std::vector<PlaceRecord> places;
  for (const auto& of_home : partition::all_to_all(peers, open))
    for (const FaceRecord& face : of_home) places.push_back(place_of(mesh, numbers, face));
  check_places(peers, places);
}

}  // namespace weft::tools
