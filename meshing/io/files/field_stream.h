// Where the values of fields go while their file is read: nobody has to hold them all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "meshing/io/files/mesh_contents.h"

namespace weft::meshing {

/// Takes fields one after the other, of formats that name the point of every value.
class FieldStream {
 public:
  /// Rows of a full block.
  static constexpr std::size_t kRows = std::size_t{1} << 15;

  virtual ~FieldStream() = default;
  /// A field of a mesh of so many points, with `length` numbers at each: 1, 3, or 9 of a full tensor.
  virtual void begin(const std::string& name, std::uint64_t length, std::uint64_t points) = 0;
  /// Rows of these points, in any order; of several of a point the last counts.
  virtual void take(std::vector<std::uint32_t> points, std::vector<double> values) = 0;
  virtual void end() = 0;
  /// Something else of the file that has no place here.
  virtual void drop(const std::string& what) = 0;
};

/// What of fields that were streamed is none (MeshContents::dropped), besides kSkewTensors.
inline constexpr const char* kFieldsWithGaps = "fields without a value at every node";

/// One field at some points that follow each other, as it comes.
class StreamedField {
 public:
  StreamedField(std::string name, std::uint64_t length, std::uint64_t first_point, std::uint64_t num_points);

  std::uint64_t length() const { return length_; }
  /// Points that are among these.
  void add(std::span<const std::uint32_t> points, std::span<const double> values);
  /// How many have a value.
  std::uint64_t num_given() const { return num_given_; }
  /// Nothing of tensors that are not symmetric. Gives the values up.
  std::optional<Field> take();

 private:
  std::string name_;
  std::uint64_t length_, first_, num_given_ = 0;
  std::vector<double> values_;
  std::vector<bool> given_;
};

/// Keeps everything.
class FieldCollector final : public FieldStream {
 public:
  explicit FieldCollector(MeshContents& contents) : contents_(contents) {}

  void begin(const std::string& name, std::uint64_t length, std::uint64_t points) override;
  void take(std::vector<std::uint32_t> points, std::vector<double> values) override;
  void end() override;
  void drop(const std::string& what) override { contents_.drop(what); }

 private:
  MeshContents& contents_;
  std::uint64_t num_points_ = 0;
  std::optional<StreamedField> field_;
};

}  // namespace weft::meshing
