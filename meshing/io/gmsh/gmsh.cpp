// Sections between $Name and $EndName; numbers in them as text or as bytes.
#include "meshing/io/gmsh/gmsh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/files/cursor.h"
#include "meshing/io/files/field_stream.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/gmsh/gmsh_codes.h"

namespace weft::meshing {
namespace {

struct ElementType {
  std::int32_t code;
  int dimension, nodes;
  const char* name;
};
constexpr ElementType kElementTypes[] = {
    {gmsh::kLine, 1, 2, "lines"},
    {gmsh::kTriangle, 2, 3, "triangles"},
    {3, 2, 4, "quadrangles"},
    {gmsh::kTetrahedron, 3, 4, "tetrahedra"},
    {5, 3, 8, "hexahedra"},
    {6, 3, 6, "prisms"},
    {7, 3, 5, "pyramids"},
    {8, 1, 3, "lines of second order"},
    {9, 2, 6, "triangles of second order"},
    {10, 2, 9, "quadrangles of second order"},
    {11, 3, 10, "tetrahedra of second order"},
    {12, 3, 27, "hexahedra of second order"},
    {13, 3, 18, "prisms of second order"},
    {14, 3, 14, "pyramids of second order"},
    {gmsh::kPoint, 0, 1, "points"},
    {16, 2, 8, "quadrangles of second order"},
    {17, 3, 20, "hexahedra of second order"},
    {18, 3, 15, "prisms of second order"},
    {19, 3, 13, "pyramids of second order"},
    {20, 2, 9, "triangles of third order"},
    {21, 2, 10, "triangles of third order"},
    {22, 2, 12, "triangles of fourth order"},
    {23, 2, 15, "triangles of fourth order"},
    {24, 2, 15, "triangles of fifth order"},
    {25, 2, 21, "triangles of fifth order"},
    {26, 1, 4, "lines of third order"},
    {27, 1, 5, "lines of fourth order"},
    {28, 1, 6, "lines of fifth order"},
    {29, 3, 20, "tetrahedra of third order"},
    {30, 3, 35, "tetrahedra of fourth order"},
    {31, 3, 56, "tetrahedra of fifth order"},
    {92, 3, 64, "hexahedra of third order"},
    {93, 3, 125, "hexahedra of fourth order"},
};
constexpr std::size_t kMostNodes = 125;

const ElementType* find_type(std::int64_t code) {
  const auto found = std::ranges::find(kElementTypes, code, &ElementType::code);
  return found == std::end(kElementTypes) ? nullptr : found;
}

/// Finds the index of a node by its tag; tags may have gaps and any order. Of tags 1, 2, 3 ... there is no
/// table.
class NodeTags {
 public:
  void add(std::uint64_t tag) {
    ++size_;
    if (consecutive_ && tag == size_) return;
    if (std::exchange(consecutive_, false)) {
      tags_.resize(size_ - 1);
      std::iota(tags_.begin(), tags_.end(), std::uint64_t{1});
    }
    tags_.push_back(tag);
  }
  std::size_t size() const { return size_; }

  /// Call once all tags are known; returns a tag that appears twice, if any.
  std::optional<std::uint64_t> build() {
    if (consecutive_) return std::nullopt;
    std::uint64_t largest = 0;
    for (const std::uint64_t tag : tags_) largest = std::max(largest, tag);
    return largest / 8 <= tags_.size() + 100 ? build_dense(largest) : build_sorted();
  }

  std::optional<std::uint32_t> find(std::uint64_t tag) const {
    if (consecutive_)
      return tag >= 1 && tag <= size_ ? std::optional(static_cast<std::uint32_t>(tag - 1)) : std::nullopt;
    if (sorted_.empty()) {
      if (tag >= dense_.size() || dense_[tag] == kNone) return std::nullopt;
      return dense_[tag];
    }
    const auto at = std::ranges::lower_bound(sorted_, tag, {}, &Entry::first);
    if (at == sorted_.end() || at->first != tag) return std::nullopt;
    return at->second;
  }

 private:
  using Entry = std::pair<std::uint64_t, std::uint32_t>;
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::optional<std::uint64_t> build_dense(std::uint64_t largest) {
    dense_.assign(largest + 1, kNone);
    for (std::size_t i = 0; i < tags_.size(); ++i) {
      if (std::exchange(dense_[tags_[i]], static_cast<std::uint32_t>(i)) != kNone) return tags_[i];
    }
    return std::nullopt;
  }
  std::optional<std::uint64_t> build_sorted() {
    for (std::size_t i = 0; i < tags_.size(); ++i) sorted_.emplace_back(tags_[i], i);
    std::ranges::sort(sorted_);
    const auto twin = std::ranges::adjacent_find(sorted_, {}, &Entry::first);
    return twin == sorted_.end() ? std::nullopt : std::optional(twin->first);
  }

  std::size_t size_ = 0;
  bool consecutive_ = true;
  std::vector<std::uint64_t> tags_;
  std::vector<std::uint32_t> dense_;
  std::vector<Entry> sorted_;
};

/// A geometric entity, or what a part of one is part of: of a higher dimension where it is between
/// partitions.
struct Entity {
  std::int64_t dimension;
  std::int32_t tag, group;
};

/// The element before the one being read.
struct LastElement {
  const ElementType* type = nullptr;
  std::int32_t entity = 0, physical = 0;
  std::vector<std::uint32_t> nodes;
};

constexpr const char* kOtherGroups = "physical groups of entities that have several";

std::string_view unquoted(std::string_view text) {
  text = trimmed(text);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') return text.substr(1, text.size() - 2);
  return text;
}

struct NodeDataHead {
  std::string name;
  std::uint64_t components, nodes;
};

/// Lines of text in every encoding.
NodeDataHead read_node_data_head(Cursor& in) {
  std::string name;
  const std::uint64_t num_strings = in.text_count();
  in.line();
  for (std::uint64_t i = 0; i < num_strings; ++i) {
    if (in.at_end()) in.fail("the file is truncated");
    const std::string_view line = in.line();
    if (i == 0) name = unquoted(line);
  }
  const std::uint64_t num_reals = in.text_count();
  for (std::uint64_t i = 0; i < num_reals; ++i) in.text_real();
  const std::uint64_t num_integers = in.text_count();
  std::array<std::uint64_t, 3> integers{};  // time step, components, nodes
  for (std::uint64_t i = 0; i < num_integers; ++i) {
    const std::int64_t value = in.text_integer();
    if (i < integers.size()) integers[i] = static_cast<std::uint64_t>(std::max<std::int64_t>(value, 0));
  }
  in.line();
  return {std::move(name), integers[1], integers[2]};
}

Field::Kind kind_of(std::uint64_t components) {
  return components == 1 ? Field::Kind::scalar : components == 3 ? Field::Kind::vector : Field::Kind::tensor;
}

class Reader {
 public:
  /// The mesh goes to the stream, all but corners, fields to theirs, if any.
  Reader(Cursor& in, MeshContents& contents, MeshStream& stream, FieldStream* fields)
      : in_(in),
        contents_(contents),
        stream_(stream),
        points_(stream, &MeshStream::take_points),
        tets_(stream, &MeshStream::take_tets),
        tet_groups_(stream, &MeshStream::take_tet_refs),
        tet_entities_(stream, &MeshStream::take_other_tet_refs),
        boundary_(stream),
        fields_(fields) {}
  /// Of a file whose nodes are `range` of `num_nodes`, which are tagged 1, 2, 3 ...: elements have any of
  /// these.
  /// `first_elements`: how many elements are before those of each block.
  Reader(Cursor& in, MeshContents& contents, MeshStream& stream, const MeshRange& range,
         std::uint64_t num_nodes, std::vector<std::uint64_t> first_elements)
      : Reader(in, contents, stream, nullptr) {
    first_node_ = range.first_point;
    num_nodes_ = num_nodes;
    first_elements_ = std::move(first_elements);
  }

  void read() {
    if (in_.word() != "$MeshFormat") throw InputError(in_.file(), "", "not an MSH file: no $MeshFormat");
    read_format();
    for (std::string_view word = in_.word(); !word.empty(); word = in_.word()) read_section(word);
    if (!has_nodes_) throw InputError(in_.file(), "$Nodes", "is missing");
    if (!has_elements_) throw InputError(in_.file(), "$Elements", "is missing");
    finish();
  }

 private:
  // Numbers of either encoding

  std::int64_t integer() { return binary_ ? in_.value<std::int32_t>() : in_.text_integer(); }
  std::int32_t integer32() { return in_.ref(integer()); }
  double real() { return binary_ ? in_.value<double>() : in_.text_real(); }
  /// Counts and tags, which have 64 bits in version 4 only.
  std::uint64_t size() {
    if (binary_ && version_ == 4) return in_.value<std::uint64_t>();
    const std::int64_t value = integer();
    if (value < 0) in_.fail("the number " + std::to_string(value) + " is negative");
    return static_cast<std::uint64_t>(value);
  }
  /// The least bytes that numbers can take: a digit and a blank each in text, but for the last blank.
  std::uint64_t least_bytes(std::uint64_t integers, std::uint64_t sizes, std::uint64_t reals) const {
    if (!binary_) return std::max<std::uint64_t>(1, 2 * (integers + sizes + reals) - 1);
    return 4 * integers + (version_ == 4 ? 8 : 4) * sizes + 8 * reals;
  }

  // Sections

  void read_format() {
    in_.enter("$MeshFormat");
    const double version = in_.text_real();
    if (version >= 2 && version < 3) {
      version_ = 2;
    } else if (version == 4.1) {
      version_ = 4;
    } else {
      in_.fail("version " + std::to_string(version) + " is not read (2.2 and 4.1 are)");
    }
    binary_ = in_.text_integer() == 1;
    const std::int64_t size = in_.text_integer();
    if (size != 8) in_.fail("numbers of " + std::to_string(size) + " bytes are not read (8 are)");
    in_.line();
    if (binary_) read_byte_order();
    in_.expect_word("$EndMeshFormat");
  }

  void read_byte_order() {
    const auto one = in_.value<std::int32_t>();
    if (one == 1) return;
    if (byte_swapped(one) != 1) in_.fail("the byte order cannot be told");
    in_.set_swapped(true);
  }

  void read_section(std::string_view begin) {
    in_.enter("");
    if (!begin.starts_with('$')) in_.fail("expected a section, found " + quoted(begin));
    const std::string name(begin.substr(1));
    in_.enter("$" + name);
    in_.line();
    if (name == "PhysicalNames") {
      read_names();
    } else if (name == "Entities" && version_ == 4) {
      read_entities(false);
    } else if (name == "PartitionedEntities" && version_ == 4) {
      pass_over_partitions();
      read_entities(true);
    } else if (name == "Nodes") {
      read_nodes();
    } else if (name == "Elements") {
      read_elements();
    } else if (name == "NodeData" && fields_) {
      read_node_data();
    } else {
      return skip_section(name);
    }
    in_.enter("$" + name);
    in_.expect_word("$End" + name);
  }

  void skip_section(const std::string& name) {
    if (!in_.find("$End" + name)) in_.fail("has no end");
    in_.line();
    if (!fields_ || name == "Comments") return;  // of a mesh alone: who reads the fields tells
    fields_->drop("sections $" + name);
  }

  void read_names() {
    const std::uint64_t count = in_.text_count();
    in_.line();
    for (std::uint64_t i = 0; i < count; ++i) {
      in_.next_row();
      const std::int64_t dimension = in_.text_integer(), tag = in_.text_integer();
      if (dimension < 0 || dimension > 3) in_.fail("dimension " + std::to_string(dimension));
      const std::string_view name = unquoted(in_.line());
      if (dimension == 0) {
        contents_.drop("names of points");
      } else {
        contents_.names.set(static_cast<int>(dimension), in_.ref(tag), std::string(name));
      }
    }
  }

  /// Keeps the first physical group of every geometric entity, or part of one.
  void read_entities(bool parts) {
    std::array<std::uint64_t, 4> counts;
    for (std::uint64_t& count : counts) count = size();
    for (int dimension = 0; dimension < 4; ++dimension) {
      for (std::uint64_t i = 0; i < counts[static_cast<std::size_t>(dimension)]; ++i) {
        in_.next_row();
        read_entity(dimension, parts);
      }
    }
  }

  void read_entity(int dimension, bool part) {
    const std::int32_t tag = integer32();
    Entity entity{dimension, tag, 0};
    if (part) read_whole_of(entity);
    for (int i = 0; i < (dimension == 0 ? 3 : 6); ++i) real();
    const std::uint64_t num_groups = size();
    for (std::uint64_t i = 0; i < num_groups; ++i) {
      const std::int32_t group = integer32();
      if (i == 0) entity.group = without_direction(dimension, group);
    }
    // Parts have the groups of their entity.
    if (num_groups > 1 && !part) contents_.drop(kOtherGroups, num_groups - 1);
    entities_[{dimension, tag}] = entity;
    if (dimension == 0) return;
    const std::uint64_t num_bounds = size();
    for (std::uint64_t i = 0; i < num_bounds; ++i) integer();
  }

  /// What a part is part of; itself where that is no entity that can have it.
  void read_whole_of(Entity& part) {
    const std::int64_t dimension = integer();
    const std::int32_t tag = integer32();
    if (dimension >= part.dimension && dimension <= 3) part = {dimension, tag, 0};
    const std::uint64_t num_partitions = size();
    for (std::uint64_t i = 0; i < num_partitions; ++i) integer();
  }

  /// Gmsh's sign says which way round an entity is in its group; weft has negative references.
  std::int32_t without_direction(int dimension, std::int32_t group) const {
    const auto& names = contents_.names.all();
    if (group >= 0 || group == std::numeric_limits<std::int32_t>::min()) return group;
    const bool turned = !names.contains({dimension, group}) && names.contains({dimension, -group});
    return turned ? -group : group;
  }

  /// Their number, and which entity has the ghosts of which.
  void pass_over_partitions() {
    size();
    const std::uint64_t num_ghosts = size();
    for (std::uint64_t i = 0; i < num_ghosts; ++i) integer(), integer();
  }

  void read_nodes() {
    if (std::exchange(has_nodes_, true)) in_.fail("appears twice");
    version_ == 2 ? read_nodes_2() : read_nodes_4();
    in_.enter("$Nodes");
    if (const auto twin = tags_.build()) in_.fail("node " + std::to_string(*twin) + " appears twice");
    points_.pass();
  }

  void require_nodes(std::uint64_t count, std::uint64_t bytes_each) const {
    in_.require(in_.entity_count(count), bytes_each);
  }

  void read_point() {
    Point p;
    for (int c = 0; c < 3; ++c) p[c] = in_.coordinate(real());
    points_.add(p);
  }

  void read_nodes_2() {
    const std::uint64_t count = in_.text_count();
    in_.line();
    in_.enter("node");
    require_nodes(count, least_bytes(1, 0, 3));
    for (std::uint64_t i = 0; i < count; ++i) {
      in_.next_row();
      tags_.add(size());
      read_point();
    }
  }

  void read_nodes_4() {
    const std::uint64_t num_blocks = size(), count = size();
    size();  // the smallest tag
    size();  // the largest
    in_.enter("node");
    require_nodes(count, least_bytes(0, 1, 3));
    for (std::uint64_t i = 0; i < num_blocks; ++i) read_node_block(count);
    if (tags_.size() == count) return;
    in_.enter("$Nodes");
    in_.fail("has " + std::to_string(tags_.size()) + " nodes instead of " + std::to_string(count));
  }

  void read_node_block(std::uint64_t total) {
    const std::int64_t dimension = integer();
    integer();  // the entity's tag
    const bool parametric = integer() != 0;
    const std::uint64_t count = size();
    if (dimension < 0 || dimension > 3) in_.fail("a block of dimension " + std::to_string(dimension));
    if (count > total - tags_.size()) in_.fail("the blocks have more nodes than $Nodes says");
    for (std::uint64_t i = 0; i < count; ++i) tags_.add(size());
    for (std::uint64_t i = 0; i < count; ++i) {
      in_.next_row();
      read_point();
      for (std::int64_t c = 0; parametric && c < dimension; ++c) real();
    }
  }

  void read_elements() {
    if (!has_nodes_) in_.fail("stands before $Nodes");
    if (std::exchange(has_elements_, true)) in_.fail("appears twice");
    if (version_ == 4) return read_elements_4();
    const std::uint64_t count = in_.text_count();
    in_.line();
    in_.enter("element");
    in_.require(count, least_bytes(4, 0, 0));
    binary_ ? read_binary_elements_2(count) : read_text_elements_2(count);
  }

  const ElementType& type_of(std::int64_t code) {
    const ElementType* type = find_type(code);
    if (!type) in_.fail("element type " + std::to_string(code) + " is unknown");
    return *type;
  }

  void read_text_elements_2(std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) {
      in_.next_row();
      integer();  // its number
      const ElementType& type = type_of(integer());
      const std::int64_t num_tags = integer();
      read_tags(num_tags);
      read_element(type);
    }
  }

  void read_binary_elements_2(std::uint64_t count) {
    std::uint64_t done = 0;
    while (done < count) {
      const ElementType& type = type_of(integer());
      const std::int64_t block = integer(), num_tags = integer();
      if (block < 1 || static_cast<std::uint64_t>(block) > count - done) {
        in_.fail("a block of " + std::to_string(block) + " elements");
      }
      for (std::int64_t i = 0; i < block; ++i) {
        in_.next_row();
        integer();  // its number
        read_tags(num_tags);
        read_element(type);
      }
      done += static_cast<std::uint64_t>(block);
    }
  }

  /// Physical group, geometric entity, and then partitions.
  void read_tags(std::int64_t num_tags) {
    if (num_tags < 0) in_.fail("a negative number of tags");
    physical_ = entity_ = 0;
    for (std::int64_t i = 0; i < num_tags; ++i) {
      const std::int32_t tag = integer32();
      if (i == 0) physical_ = tag;
      if (i == 1) entity_ = tag;
    }
  }

  void read_elements_4() {
    const std::uint64_t num_blocks = size(), count = size();
    size();  // the smallest tag
    size();  // the largest
    in_.enter("element");
    in_.require(count, least_bytes(0, 2, 0));
    for (std::uint64_t i = 0; i < num_blocks; ++i) {
      if (is_range()) in_.enter("element", first_elements_[i]);
      read_element_block();
    }
    if (in_.row() == count || is_range()) return;
    const std::uint64_t found = in_.row();
    in_.enter("$Elements");
    in_.fail("has " + std::to_string(found) + " elements instead of " + std::to_string(count));
  }

  void read_element_block() {
    const std::int64_t dimension = integer();
    const std::int32_t tag = integer32();
    const ElementType& type = type_of(integer());
    const std::uint64_t count = size();
    if (dimension != type.dimension) {
      in_.fail(std::string(type.name) + " in an entity of dimension " + std::to_string(dimension));
    }
    const auto known = entities_.find({type.dimension, tag});
    const Entity entity = known == entities_.end() ? Entity{dimension, tag, 0} : known->second;
    entity_ = entity.tag;
    physical_ = entity.group;
    between_partitions_ = entity.dimension != dimension;
    if (is_range()) note_group(type);  // of which all elements may be elsewhere
    in_.require(count, least_bytes(0, 1 + static_cast<std::uint64_t>(type.nodes), 0));
    for (std::uint64_t i = 0; i < count; ++i) {
      in_.next_row();
      size();  // its tag
      read_element(type);
    }
  }

  /// Whether this is a part of the file.
  bool is_range() const { return num_nodes_ > 0; }

  /// Where any element of a dimension has a group, groups are the references.
  void note_group(const ElementType& type) {
    if (type.code == gmsh::kTetrahedron || type.code == gmsh::kTriangle || type.code == gmsh::kLine)
      have_groups_[static_cast<std::size_t>(type.dimension)] |= physical_ != 0;
  }

  std::uint32_t read_node() {
    const std::uint64_t tag = size();
    const auto index = !is_range()                     ? tags_.find(tag)
                       : tag >= 1 && tag <= num_nodes_ ? std::optional(static_cast<std::uint32_t>(tag - 1))
                                                       : std::nullopt;
    if (!index) in_.fail("node " + std::to_string(tag) + " does not exist");
    return *index;
  }

  void read_element(const ElementType& type) {
    std::array<std::uint32_t, kMostNodes> nodes;
    for (int i = 0; i < type.nodes; ++i) nodes[static_cast<std::size_t>(i)] = read_node();
    if (between_partitions_) return contents_.drop("elements between partitions");
    if (version_ == 2 && is_repeated(type, std::span(nodes).first(static_cast<std::size_t>(type.nodes))))
      return;
    BoundaryRows& boundary = boundary_.rows;
    switch (type.code) {
      case gmsh::kTetrahedron:
        tets_.add({nodes[0], nodes[1], nodes[2], nodes[3]});
        tet_groups_.add(physical_);
        tet_entities_.add(entity_);
        break;
      case gmsh::kTriangle:
        boundary.rows.triangles.push_back({nodes[0], nodes[1], nodes[2]});
        boundary.rows.triangle_refs.push_back(physical_);
        boundary.other_triangle_refs.push_back(entity_);
        boundary_.pass_if_full();
        break;
      case gmsh::kLine:
        boundary.rows.edges.push_back({nodes[0], nodes[1]});
        boundary.rows.edge_refs.push_back(physical_);
        boundary.other_edge_refs.push_back(entity_);
        boundary_.pass_if_full();
        break;
      case gmsh::kPoint:
        contents_.mesh.corners.push_back(nodes[0]);
        corner_groups_.push_back(physical_);
        break;
      default:
        ++foreign_[&type];
        return;
    }
    note_group(type);
  }

  /// Version 2 has an element once for each of its physical groups, turned where it is so in the group; the
  /// first counts.
  bool is_repeated(const ElementType& type, std::span<const std::uint32_t> nodes) {
    const bool same = last_.type == &type && last_.entity == entity_ && last_.physical != physical_ &&
                      std::ranges::is_permutation(last_.nodes, nodes);
    if (!same) {
      last_.type = &type, last_.entity = entity_, last_.physical = physical_;
      last_.nodes.assign(nodes.begin(), nodes.end());
    } else if (other_groups_.insert({type.dimension, entity_, physical_}).second) {
      contents_.drop(kOtherGroups);
    }
    return same;
  }

  void read_node_data() {
    const NodeDataHead head = read_node_data_head(in_);
    read_field(head.name, head.components, head.nodes);
  }

  void read_field(const std::string& name, std::uint64_t length, std::uint64_t count) {
    if (!has_nodes_) in_.fail("stands before $Nodes");
    if (length != 1 && length != 3 && length != 9) in_.fail("has " + std::to_string(length) + " components");
    in_.require(count, least_bytes(1, 0, length));
    fields_->begin(name, length, tags_.size());
    std::vector<std::uint32_t> nodes;
    std::vector<double> values;
    const auto pass = [&] { fields_->take(std::exchange(nodes, {}), std::exchange(values, {})); };
    for (std::uint64_t i = 0; i < count; ++i) {
      in_.next_row();
      const std::int64_t tag = integer();
      const auto node = tags_.find(static_cast<std::uint64_t>(tag));
      if (!node) in_.fail("node " + std::to_string(tag) + " does not exist");
      nodes.push_back(*node);
      for (std::uint64_t c = 0; c < length; ++c) values.push_back(real());
      if (nodes.size() == FieldStream::kRows) pass();
    }
    pass();
    fields_->end();
  }

  void finish() {
    for (const auto& [type, count] : foreign_) {
      type->dimension == 3 ? contents_.drop_volumes(type->name, count) : contents_.drop(type->name, count);
    }
    boundary_.pass();
    tets_.pass();
    tet_groups_.pass();
    tet_entities_.pass();
    for (const int dimension : {1, 2, 3})
      if (!have_groups_[static_cast<std::size_t>(dimension)]) stream_.prefer_other_refs(dimension);
    std::vector<std::uint32_t>& corners = contents_.mesh.corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {  // their entities are just their numbers
      const std::uint64_t place = std::uint64_t{corners[i]} - first_node_;
      if (place < points_.count())
        stream_.set_point_ref(static_cast<std::uint32_t>(place), corner_groups_[i]);
    }
    std::ranges::sort(corners);  // a point can be in several groups
    corners.erase(std::ranges::unique(corners).begin(), corners.end());
  }

  Cursor& in_;
  MeshContents& contents_;
  MeshStream& stream_;
  StreamedRows<Point> points_;
  StreamedRows<std::array<std::uint32_t, 4>> tets_;
  StreamedRows<std::int32_t> tet_groups_, tet_entities_;
  StreamedBoundary boundary_;
  std::array<bool, 4> have_groups_{};  ///< elements of each dimension, those elsewhere among them
  std::vector<std::int32_t> corner_groups_;
  FieldStream* fields_;
  std::uint64_t first_node_ = 0, num_nodes_ = 0;  ///< num_nodes_: 0 without a range
  std::vector<std::uint64_t> first_elements_;     ///< of each block; empty without a range
  int version_ = 4;
  bool binary_ = false, has_nodes_ = false, has_elements_ = false;
  std::map<std::pair<int, std::int32_t>, Entity> entities_;
  NodeTags tags_;
  std::map<const ElementType*, std::uint64_t> foreign_;
  std::int32_t physical_ = 0, entity_ = 0;  ///< of the element being read
  bool between_partitions_ = false;
  // Of version 2:
  LastElement last_;
  std::set<std::array<std::int32_t, 3>> other_groups_;  ///< not kept: dimension, entity, physical group
};

/// Where the rows of a binary file of version 4.1 are. Its nodes come without parameters, $Elements follows
/// $Nodes, and it has no partitions, the elements between which would not count.
class Layout {
 public:
  /// Nothing for files of other kinds. Throws InputError where the file is damaged.
  static std::optional<Layout> of(const InputFile& file) {
    Layout layout(file);
    if (!layout.read_head() || !layout.read_nodes() || !layout.read_elements()) return std::nullopt;
    return layout;
  }

  MeshSize size() const { return {num_nodes_, num_tets_}; }
  /// Behind the last element.
  std::uint64_t end_of_elements() const {
    return blocks_.empty() ? 0 : blocks_.back().position + blocks_.back().count * blocks_.back().row();
  }
  /// Reads all tags; the counts alone allow others.
  bool are_tags_consecutive() const {
    return std::ranges::all_of(nodes_, [&](const NodeBlock& block) { return are_tags_consecutive(block); });
  }

  /// A file of the range's elements and nodes, and of all elements of kinds that ranges do not cut.
  /// `first_elements`: how many elements of the whole file are before those of each block.
  std::string part(const MeshRange& range, std::vector<std::uint64_t>& first_elements) const {
    std::string bytes = head_;
    put_all<std::uint64_t>(bytes, {range.num_points > 0, range.num_points, 1, range.num_points});
    if (range.num_points > 0) {
      put_all<std::int32_t>(bytes, {3, 1, 0});
      put_all<std::uint64_t>(bytes, {range.num_points});
      copy_nodes(range, kTag, &NodeBlock::tags, bytes);
      copy_nodes(range, kCoordinates, &NodeBlock::coordinates, bytes);
    }
    bytes += "\n$EndNodes\n$Elements\n";
    std::uint64_t count = 0, in_front = 0;
    std::string blocks;
    std::array<Cut, 3> cuts{Cut{gmsh::kTetrahedron, range.first_tet, range.first_tet + range.num_tets},
                            part_of(gmsh::kTriangle, range), part_of(gmsh::kLine, range)};
    for (const ElementBlock& block : blocks_) {
      if (block.count == 0) continue;
      std::uint64_t first = 0, number = block.count;
      for (Cut& cut : cuts)
        if (block.type->code == cut.code) cut.take(first, number);
      put_all<std::int32_t>(blocks, {block.type->dimension, block.entity, block.type->code});
      put_all<std::uint64_t>(blocks, {number});
      copy(block.position + first * block.row(), number * block.row(), blocks);
      count += number;
      first_elements.push_back(in_front + first);
      in_front += block.count;
    }
    put_all<std::uint64_t>(bytes, {first_elements.size(), count, 1, count});
    return bytes + blocks + "\n$EndElements\n";
  }

 private:
  static constexpr std::uint64_t kTag = sizeof(std::uint64_t), kCoordinates = 3 * sizeof(double);
  static constexpr std::string_view kNodes = "\n$Nodes\n", kBetween = "\n$EndNodes\n$Elements\n";

  struct NodeBlock {
    std::uint64_t first, count, tags, coordinates;  ///< number of the first node; positions
  };
  struct ElementBlock {
    const ElementType* type;
    std::int32_t entity;
    std::uint64_t count, position;
    std::uint64_t row() const { return (1 + static_cast<std::uint64_t>(type->nodes)) * kTag; }
  };

  /// Of all elements of a type those from `begin` to before `end`.
  struct Cut {
    int code;
    std::uint64_t begin, end, passed = 0;

    /// Of the next `number` elements, from `first` so many.
    void take(std::uint64_t& first, std::uint64_t& number) {
      const std::uint64_t last = passed + number;
      first = std::clamp(begin, passed, last) - passed;
      number = std::clamp(end, passed + first, last) - passed - first;
      passed = last;
    }
  };
  Cut part_of(int code, const MeshRange& range) const {
    std::uint64_t total = 0;
    for (const ElementBlock& block : blocks_)
      if (block.type->code == code) total += block.count;
    return {code, range.part_begin(total), range.part_end(total)};
  }

  explicit Layout(const InputFile& file) : file_(file) {}

  /// Up to the rows of $Nodes.
  bool read_head() {
    std::size_t end = std::string::npos;
    for (std::uint64_t size = 1u << 16; end == std::string::npos; size *= 2) {
      head_.resize(std::min(size, file_.size()));
      file_.read_at(0, head_.data(), head_.size());
      if (!head_.starts_with("$MeshFormat"))
        throw InputError(file_.name(), "", "not an MSH file: no $MeshFormat");
      if (!is_binary_4()) return false;
      if (head_.find("\n$PartitionedEntities") != std::string::npos) return false;
      end = head_.find(kNodes);
      if (end == std::string::npos && size >= file_.size()) return false;
    }
    head_.resize(at_ = end + kNodes.size());
    return true;
  }

  bool is_binary_4() {
    Cursor in(file_.name(), head_);
    in.line();
    if (in.word() != "4.1" || in.word() != "1" || in.word() != "8") return false;
    in.line();
    const auto one = in.value<std::int32_t>();
    swapped_ = one != 1;
    return one == 1 || byte_swapped(one) == 1;
  }

  bool read_nodes() {
    const auto num_blocks = next<std::uint64_t>();
    num_nodes_ = next<std::uint64_t>();
    const auto least = next<std::uint64_t>(), largest = next<std::uint64_t>();
    if (num_nodes_ == 0 || num_nodes_ > 0xFFFFFFFE || least != 1 || largest != num_nodes_) return false;
    std::uint64_t passed = 0;
    for (std::uint64_t i = 0; i < num_blocks; ++i) {
      next<std::int32_t>(), next<std::int32_t>();
      if (next<std::int32_t>() != 0) return false;  // parameters
      const auto count = next<std::uint64_t>();
      if (count > num_nodes_ - passed) return false;
      require(count, kTag + kCoordinates);
      nodes_.push_back({passed, count, at_, at_ + count * kTag});
      at_ += count * (kTag + kCoordinates);
      passed += count;
    }
    std::string between(kBetween.size(), ' ');
    require(between.size(), 1);
    file_.read_at(at_, between.data(), between.size());
    at_ += between.size();
    return passed == num_nodes_ && between == kBetween;
  }

  bool are_tags_consecutive(const NodeBlock& block) const {
    constexpr std::uint64_t kAtOnce = 1u << 14;
    std::vector<char> bytes(std::min(block.count, kAtOnce) * kTag);
    for (std::uint64_t begin = 0; begin < block.count; begin += kAtOnce) {
      const std::uint64_t n = std::min(kAtOnce, block.count - begin);
      file_.read_at(block.tags + begin * kTag, bytes.data(), n * kTag);
      for (std::uint64_t i = 0; i < n; ++i)
        if (load<std::uint64_t>(bytes.data() + i * kTag, swapped_) != block.first + begin + i + 1)
          return false;
    }
    return true;
  }

  bool read_elements() {
    const auto num_blocks = next<std::uint64_t>(), num_elements = next<std::uint64_t>();
    next<std::uint64_t>(), next<std::uint64_t>();
    std::uint64_t passed = 0;
    for (std::uint64_t i = 0; i < num_blocks; ++i) {
      const auto dimension = next<std::int32_t>(), entity = next<std::int32_t>(), code = next<std::int32_t>();
      const auto count = next<std::uint64_t>();
      const ElementType* type = find_type(code);
      if (!type || type->dimension != dimension) return false;
      const ElementBlock& block = blocks_.emplace_back(ElementBlock{type, entity, count, at_});
      require(count, block.row());
      at_ += count * block.row();
      passed += count;
      if (code == gmsh::kTetrahedron) num_tets_ += count;
    }
    require(std::string_view("\n$EndElements").size(), 1);
    return passed == num_elements;
  }

  void require(std::uint64_t count, std::uint64_t size) const {
    if (count > (file_.size() - at_) / size) throw InputError(file_.name(), "", "the file is truncated");
  }
  template <class T>
  T next() {
    require(1, sizeof(T));
    std::array<char, sizeof(T)> bytes;
    file_.read_at(at_, bytes.data(), bytes.size());
    at_ += sizeof(T);
    return load<T>(bytes.data(), swapped_);
  }
  template <class T>
  void put_all(std::string& bytes, std::initializer_list<T> values) const {
    for (T value : values) {
      if (swapped_) value = byte_swapped(value);
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
  }
  void copy(std::uint64_t position, std::uint64_t size, std::string& bytes) const {
    bytes.resize(bytes.size() + size);
    file_.read_at(position, bytes.data() + bytes.size() - size, size);
  }
  /// A row of `size` bytes of every node in the range.
  void copy_nodes(const MeshRange& range, std::uint64_t size, std::uint64_t NodeBlock::*rows,
                  std::string& bytes) const {
    for (const NodeBlock& block : nodes_) {
      const std::uint64_t end = block.first + block.count;
      const std::uint64_t first = std::clamp(range.first_point, block.first, end);
      const std::uint64_t last = std::clamp(range.first_point + range.num_points, first, end);
      copy(block.*rows + (first - block.first) * size, (last - first) * size, bytes);
    }
  }

  const InputFile& file_;
  std::uint64_t at_ = 0;
  bool swapped_ = false;
  std::string head_;
  std::vector<NodeBlock> nodes_;
  std::vector<ElementBlock> blocks_;
  std::uint64_t num_nodes_ = 0, num_tets_ = 0;
};

}  // namespace

std::optional<MeshSize> gmsh_size(const std::filesystem::path& path) {
  const InputFile file(path);
  const auto layout = Layout::of(file);
  return layout && layout->are_tags_consecutive() ? std::optional(layout->size()) : std::nullopt;
}

MeshContents read_gmsh_range(const std::filesystem::path& path, const MeshRange& range) {
  const InputFile file(path);
  const auto layout = Layout::of(file);
  if (!layout) throw InputError(path.string(), "", "has changed while it was read");
  std::vector<std::uint64_t> first_elements;
  const std::string bytes = layout->part(range, first_elements);
  Cursor in(file.name(), bytes);
  MeshContents contents;
  MeshCollector collector;
  Reader(in, contents, collector, range, layout->size().points, std::move(first_elements)).read();
  keep_part_of_corners(range, contents.mesh);
  collector.put_into(contents.mesh);
  contents.complete();
  return contents;
}

MeshContents read_gmsh(const std::filesystem::path& path, Coordinates wanted) {
  const InputFile file(path);
  Cursor in(file);
  in.set_coordinates(wanted);
  MeshContents contents;
  MeshCollector collector;
  FieldCollector fields(contents);
  Reader(in, contents, collector, &fields).read();
  collector.put_into(contents.mesh);
  contents.complete();
  return contents;
}

SolutionData gmsh_field_heads(const std::filesystem::path& path) {
  const InputFile file(path);
  Cursor in(file);
  if (const auto layout = Layout::of(file)) in.seek(layout->end_of_elements());  // else all is passed over
  SolutionData heads;
  while (in.find("$NodeData")) {
    in.line();
    const NodeDataHead head = read_node_data_head(in);
    heads.fields.push_back({kind_of(head.components), {}, head.name});
  }
  return heads;
}

namespace {

MeshContents stream(const std::filesystem::path& path, MeshStream& mesh, FieldStream* fields) {
  const InputFile file(path);
  Cursor in(file);
  MeshContents contents;
  Reader(in, contents, mesh, fields).read();
  return contents;
}

}  // namespace

MeshContents stream_gmsh(const std::filesystem::path& path, MeshStream& mesh) {
  return stream(path, mesh, nullptr);
}

void stream_gmsh_fields(const std::filesystem::path& path, FieldStream& fields) {
  MeshStream nobody;  // somebody else reads the mesh
  stream(path, nobody, &fields);
}

}  // namespace weft::meshing
