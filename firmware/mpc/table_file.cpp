// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/mpc/table_file.h"

#include <algorithm>
#include <bit>

namespace m100::mpc {
namespace {

/// Takes little-endian numbers from the front of a span of bytes; past the end it gives zeros, and done() stays false.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::uint64_t unsigned_number(std::size_t size) {
    if (bytes_.size() < size) {
      overrun_ = true;
      bytes_ = {};
      return 0;
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      value |= static_cast<std::uint64_t>(bytes_[i]) << (8 * i);
    }
    bytes_ = bytes_.subspan(size);
    return value;
  }
  double number() { return std::bit_cast<double>(unsigned_number(8)); }
  std::uint32_t count() { return static_cast<std::uint32_t>(unsigned_number(4)); }
  bool done() const { return !overrun_ && bytes_.empty(); }

 private:
  std::span<const std::byte> bytes_;
  bool overrun_ = false;
};

/// Whether every path through the tree ends inside the tables: children come after their parents.
bool tree_is_sound(std::span<const SetpointNode> nodes, std::size_t laws) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (const std::uint16_t child : nodes[i].child) {
      const bool leaf = (child & SetpointTree<float>::kLeaf) != 0;
      if (leaf ? (child & ~SetpointTree<float>::kLeaf) >= static_cast<int>(laws)
               : child <= i || child >= nodes.size()) {
        return false;
      }
    }
  }
  return true;
}

template <typename T, typename Rows>
bool read_axis(Reader& reader, const core::Sha256Digest& vehicle, Rows& rows, GainTable<T>& table) {
  std::array<double, kTableNumbers> list;
  for (double& number : list) {
    number = reader.number();
  }
  table = table_of<T>(list, vehicle);
  const std::size_t laws = reader.count();
  const std::size_t nodes = reader.count();
  if (laws > kMaxSetpointLaws || nodes > kMaxSetpointNodes) {
    return false;
  }
  for (std::size_t i = 0; i < nodes * kNodeNumbers; ++i) {
    rows.planes[i] = static_cast<T>(reader.number());
  }
  rows.planes[nodes * kNodeNumbers] = T(0);
  for (std::size_t i = 0; i < laws * kLawNumbers; ++i) {
    rows.laws[i] = static_cast<T>(reader.number());
  }
  for (std::size_t i = 0; i < nodes; ++i) {
    for (std::uint16_t& child : rows.nodes[i].child) {
      child = static_cast<std::uint16_t>(reader.unsigned_number(2));
    }
  }
  table.setpoint.planes = std::span<const T>(rows.planes).first(nodes * kNodeNumbers + 1);
  table.setpoint.laws = std::span<const T>(rows.laws).first(laws * kLawNumbers);
  table.setpoint.nodes = std::span<const SetpointNode>(rows.nodes).first(nodes);
  return (table.states == 3 || table.states == 4) && table.input_min_slope < table.input_max_slope &&
         tree_is_sound(table.setpoint.nodes, laws);
}

}  // namespace

template <typename T>
core::Status TableStorage<T>::load(std::span<const std::byte> file, const core::Sha256Digest& vehicle) {
  constexpr std::size_t kDigestBytes = std::tuple_size_v<core::Sha256Digest>;
  constexpr std::size_t kHeaderBytes = 16 + kDigestBytes;
  const auto same_byte = [](auto a, std::byte b) { return static_cast<std::byte>(a) == b; };
  if (file.size() < kHeaderBytes + kDigestBytes || file.size() > kMaxTableFileBytes ||
      !std::equal(kTableFileMagic.begin(), kTableFileMagic.end(), file.begin(), same_byte)) {
    return core::Status::kInvalidArgument;
  }
  const std::span<const std::byte> body = file.first(file.size() - kDigestBytes);
  const core::Sha256Digest sum = core::sha256(body);
  if (!std::equal(sum.begin(), sum.end(), file.end() - kDigestBytes, same_byte)) {
    return core::Status::kDataLoss;
  }
  if (Reader(file.subspan(8, 4)).count() != kTableFileVersion) {
    return core::Status::kInvalidArgument;
  }
  if (!std::equal(vehicle.begin(), vehicle.end(), file.begin() + 16, same_byte)) {
    return core::Status::kRefused;
  }
  Reader reader(body.subspan(kHeaderBytes));
  const bool sound = read_axis(reader, vehicle, x_rows_, tables_.x) && read_axis(reader, vehicle, y_rows_, tables_.y);
  if (!sound || !reader.done()) {
    tables_ = {};
    return core::Status::kInvalidArgument;
  }
  return core::Status::kOk;
}

template class TableStorage<float>;
template class TableStorage<double>;

}  // namespace m100::mpc
