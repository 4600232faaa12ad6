// What a section of a CGNS file has of its elements, passed over block by block: nobody holds all of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "meshing/io/cgns_library.h"

namespace weft::meshing::cgns {

/// The numbers of a section's ElementConnectivity, in 64 bits whatever the file has. Reads past the library's
/// functions for sections: these read all of it where its integers are not the library's own, and of mixed
/// elements version 3.4 reads wrong ranges.
class SectionData {
 public:
  /// How many numbers are in memory at a time.
  static constexpr std::size_t kBlock = std::size_t{1} << 16;

  /// Of the section of this name. Throws InputError where it has no list of numbers.
  SectionData(const Library& library, int zone, const std::string& section);

  std::uint64_t size() const { return size_; }
  std::uint64_t left() const { return size_ - next_; }
  /// What take() gives next; at most size().
  void seek(std::uint64_t place) { next_ = place; }
  /// The next `count` numbers, which stay until the next call; null where fewer are left. Throws InputError
  /// where the file cannot be read.
  const std::int64_t* take(std::size_t count);

 private:
  /// A node of the file's tree, by its parent and its name.
  class Node {
   public:
    Node(const SectionData& section, double parent, const std::string& name);
    ~Node();
    Node(const Node&) = delete;
    Node& operator=(const Node&) = delete;
    double id() const { return id_; }

   private:
    int io_;
    double id_ = 0;
  };

  int io_of_library() const;
  double zone_node(int zone) const;
  std::uint64_t length() const;
  void check(int status) const;
  void read_block(std::size_t count);

  const Library& library_;
  std::string entity_;  ///< the section, in messages
  int io_;              ///< the file, as the library's lower level has it
  Node section_, data_;
  std::uint64_t size_, next_ = 0;
  std::uint64_t first_ = 0;  ///< of the block
  std::vector<std::int64_t> block_;
};

}  // namespace weft::meshing::cgns
