// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/status.h"
#include "firmware/mpc/gain_table.h"
#include "firmware/mpc/table_data.h"

namespace m100::mpc {

/// A gain table file, for programs that get their vehicle at run time. Little-endian:
///   "M100GAIN" | version u32 | 0 u32 | SHA-256 of the vehicle file | axis x | axis y | SHA-256 of all before
///   axis: kTableNumbers doubles | laws, nodes u32 each | kNodeNumbers doubles per node | rows of 9 doubles per law |
///   nodes of 8 u16
inline constexpr std::array<char, 8> kTableFileMagic{'M', '1', '0', '0', 'G', 'A', 'I', 'N'};
inline constexpr std::uint32_t kTableFileVersion = 2;
inline constexpr std::size_t kMaxSetpointLaws = 256;
inline constexpr std::size_t kMaxSetpointNodes = 1024;
inline constexpr std::size_t kMaxTableFileBytes =
    88 + 2 * (8 * kTableNumbers + 8 + 8 * kLawNumbers * kMaxSetpointLaws + 8 * (kNodeNumbers + 2) * kMaxSetpointNodes);

/// Room for the tables of one file. Large: make it static, or once at start-up.
template <typename T>
class TableStorage {
 public:
  /// Reads a file's bytes. Call it before the first tick: no controller may use tables() yet. A refused file leaves the
  /// former tables, or empty ones whose limits are zero:
  ///   kDataLoss: the file's checksum is wrong;
  ///   kInvalidArgument: not a table file, another version, or impossible sizes or limits;
  ///   kRefused: the table was made from another vehicle file.
  core::Status load(std::span<const std::byte> file, const core::Sha256Digest& vehicle);

  const GainTables<T>& tables() const { return tables_; }

 private:
  struct Rows {
    std::array<T, kMaxSetpointNodes * kNodeNumbers + 1> planes;
    std::array<T, kMaxSetpointLaws * kLawNumbers> laws;
    std::array<SetpointNode, kMaxSetpointNodes> nodes;
  };
  GainTables<T> tables_;
  Rows x_rows_;
  Rows y_rows_;
};

extern template class TableStorage<float>;
extern template class TableStorage<double>;

}  // namespace m100::mpc
