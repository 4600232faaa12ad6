// Ranges are read by the lower level of the library, which knows nodes and arrays, but no elements.
#include "meshing/io/cgns_section_data.h"

#include <cgns_io.h>

#include <algorithm>
#include <array>

namespace weft::meshing::cgns {

SectionData::Node::Node(const SectionData& section, double parent, const std::string& name)
    : io_(section.io_) {
  section.check(cgio_get_node_id(io_, parent, name.c_str(), &id_));
}

SectionData::Node::~Node() { cgio_release_id(io_, id_); }

SectionData::SectionData(const Library& library, int zone, const std::string& section)
    : library_(library),
      entity_("section " + section),
      io_(io_of_library()),
      section_(*this, zone_node(zone), section),
      data_(*this, section_.id(), "ElementConnectivity"),
      size_(length()) {}

int SectionData::io_of_library() const {
  int io = 0;
  library_.check(cg_get_cgio(library_.file(), &io), entity_);
  return io;
}

double SectionData::zone_node(int zone) const {
  double id = 0;
  library_.check(cg_zone_id(library_.file(), kBase, zone, &id), entity_);
  return id;
}

std::uint64_t SectionData::length() const {
  int dimensions = 0;
  std::array<cgsize_t, CGIO_MAX_DIMENSIONS> lengths{};
  check(cgio_get_dimensions(io_, data_.id(), &dimensions, lengths.data()));
  if (dimensions != 1) library_.fail(entity_, "its data are no list of numbers");
  return static_cast<std::uint64_t>(lengths[0]);
}

void SectionData::check(int status) const {
  if (status == CGIO_ERR_NONE) return;
  std::array<char, CGIO_MAX_ERROR_LENGTH + 1> reason{};
  cgio_error_message(reason.data());
  library_.fail(entity_, reason.data());
}

const std::int64_t* SectionData::take(std::size_t count) {
  if (count > left()) return nullptr;
  if (next_ < first_ || next_ + count > first_ + block_.size()) read_block(count);
  const std::int64_t* numbers = block_.data() + (next_ - first_);
  next_ += count;
  return numbers;
}

/// From the next number on, which is in the file: at least `count`.
void SectionData::read_block(std::size_t count) {
  block_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(std::max(kBlock, count), left())));
  first_ = next_;
  const auto begin = static_cast<cgsize_t>(first_ + 1), end = static_cast<cgsize_t>(first_ + block_.size()),
             all = static_cast<cgsize_t>(block_.size());
  const cgsize_t one = 1;
  check(cgio_read_data_type(io_, data_.id(), &begin, &end, &one, "I8", 1, &all, &one, &all, &one,
                            block_.data()));
}

}  // namespace weft::meshing::cgns
