// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/mpc/table_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "firmware/core/sha256.h"
#include "host_tests/lab/gains/write_tables.h"

namespace m100::mpc {
namespace {

using core::Status;
using lab::gains::TableSet;
using lab::gains::to_file;

TableSet made_from(const companion::VehicleFile& file) {
  TableSet set;
  set.tables = lab::gains::make_gain_tables(file.vehicle, file.digest);
  set.x.planes.assign(2 * kNodeNumbers + 1, 0.5);
  set.x.laws.assign(3 * kLawNumbers, -2.0);
  constexpr auto kLeaf = SetpointTree<double>::kLeaf;
  set.x.nodes = {{{kLeaf, 1, 1, 1, 1, 1, 1, 1}}, {{kLeaf + 1, kLeaf + 2, kLeaf, kLeaf, kLeaf, kLeaf, kLeaf, kLeaf}}};
  return set;
}

struct TableFile : ::testing::Test {
  const companion::VehicleFile file = companion::load_vehicle("firmware/mpc/generated/vehicle.toml");
  const TableSet set = made_from(file);
  const std::vector<std::byte> bytes = to_file(set);
  const std::unique_ptr<TableStorage<double>> storage = std::make_unique<TableStorage<double>>();
};

TEST_F(TableFile, ComesBackToTheLastBit) {
  ASSERT_EQ(storage->load(bytes, file.digest), Status::kOk);
  const GainTables<double>& tables = storage->tables();
  EXPECT_EQ(tables.x.filter_gain, set.tables.x.filter_gain);
  EXPECT_EQ(tables.y.state_gain, set.tables.y.state_gain);
  EXPECT_EQ(tables.y.delay.rest.transition, set.tables.y.delay.rest.transition);
  EXPECT_EQ(tables.x.vehicle, file.digest);
  ASSERT_EQ(tables.x.setpoint.nodes.size(), 2U);
  EXPECT_EQ(tables.x.setpoint.nodes[1].child[1], SetpointTree<double>::kLeaf + 2);
  EXPECT_EQ(tables.x.setpoint.laws[26], -2.0);
  EXPECT_TRUE(tables.y.setpoint.nodes.empty());
}

TEST_F(TableFile, InFloatIsTheTableOfTheFirmware) {
  const auto single = std::make_unique<TableStorage<float>>();
  ASSERT_EQ(single->load(bytes, file.digest), Status::kOk);
  EXPECT_EQ(single->tables().y.filter_gain, lab::gains::to_float(set.tables.y).filter_gain);
}

// Without this check the controller's own assertion would end the flight program. Catches tables that are half the
// former ones, half those of the refused file.
TEST_F(TableFile, WithLimitsThatCrossIsRefusedAndLeavesNothingToFly) {
  TableSet crossed = made_from(file);
  std::swap(crossed.tables.y.input_min_slope, crossed.tables.y.input_max_slope);
  ASSERT_EQ(storage->load(bytes, file.digest), Status::kOk);
  EXPECT_EQ(storage->load(to_file(crossed), file.digest), Status::kInvalidArgument);
  for (const GainTable<double>* axis : {&storage->tables().x, &storage->tables().y}) {
    EXPECT_FALSE(axis->input_min_slope < axis->input_max_slope) << "with these limits no controller begins";
  }
}

// Catches rows that are written past the end of their array.
TEST_F(TableFile, WithMoreLawsOrNodesThanThereIsRoomForIsRefused) {
  TableSet full = made_from(file);
  full.x.laws.assign(kMaxSetpointLaws * kLawNumbers, -2.0);
  EXPECT_EQ(storage->load(to_file(full), file.digest), Status::kOk);
  TableSet laws = made_from(file);
  laws.x.laws.assign((kMaxSetpointLaws + 1) * kLawNumbers, -2.0);
  EXPECT_EQ(storage->load(to_file(laws), file.digest), Status::kInvalidArgument);
  TableSet nodes = made_from(file);
  nodes.x.nodes.assign(kMaxSetpointNodes + 1, nodes.x.nodes.back());
  nodes.x.planes.assign((kMaxSetpointNodes + 1) * kNodeNumbers + 1, 0.5);
  EXPECT_EQ(storage->load(to_file(nodes), file.digest), Status::kInvalidArgument);
}

#ifdef M100_SANITIZED
constexpr std::size_t kStride = 13;  // the release build tries every byte; under sanitizers that takes minutes
#else
constexpr std::size_t kStride = 1;
#endif

// Catches a digest over a part of the file, or one that is compared in part.
class EveryBit : public TableFile, public ::testing::WithParamInterface<unsigned> {};
TEST_P(EveryBit, OfATableFileIsGuarded) {
  RecordProperty("promise", "R10");
  std::vector<std::byte> damaged = bytes;
  std::size_t accepted = 0;
  for (std::size_t i = 0; i < damaged.size(); i += kStride) {
    damaged[i] ^= std::byte{1} << GetParam();
    accepted += storage->load(damaged, file.digest) == Status::kOk ? 1U : 0U;
    damaged[i] ^= std::byte{1} << GetParam();
  }
  EXPECT_EQ(accepted, 0U);
  EXPECT_EQ(storage->load(damaged, file.digest), Status::kOk);
}
INSTANTIATE_TEST_SUITE_P(Bit, EveryBit, ::testing::Range(0U, 8U));

TEST_F(TableFile, IsRefusedAfterAnyBitOfTheVehicleFileHasChanged) {
  RecordProperty("promise", "R10");
  std::string text = companion::to_text(file.vehicle, file.sources);
  const companion::VehicleFile original = companion::parse_vehicle(text, "vehicle");
  const std::vector<std::byte> table = to_file(made_from(original));
  std::size_t accepted = 0;
  for (std::size_t i = 0; i < text.size(); i += kStride) {
    char& letter = text[i];
    for (unsigned bit = 0; bit < 8; ++bit) {
      letter = static_cast<char>(static_cast<unsigned char>(letter) ^ (1U << bit));
      try {
        accepted += storage->load(table, companion::parse_vehicle(text, "vehicle").digest) == Status::kOk ? 1U : 0U;
      } catch (const companion::FileError&) {
        // refused even earlier
      }
      letter = static_cast<char>(static_cast<unsigned char>(letter) ^ (1U << bit));
    }
  }
  EXPECT_EQ(accepted, 0U);
  EXPECT_EQ(storage->load(table, original.digest), Status::kOk);
}

TEST_F(TableFile, MadeFromAnotherVehicleIsRefused) {
  RecordProperty("promise", "R10");
  model::Vehicle other = file.vehicle;
  other.pitch.damping_ratio = std::nextafter(other.pitch.damping_ratio, 1.0);
  EXPECT_EQ(storage->load(to_file(made_from(companion::as_file(other))), file.digest), Status::kRefused);
}

TEST_F(TableFile, OfAnyOtherLengthIsRefused) {
  for (std::size_t length = 0; length < bytes.size(); length += length < 200 ? 1 : 97) {
    EXPECT_NE(storage->load(std::span(bytes).first(length), file.digest), Status::kOk) << length;
  }
  std::vector<std::byte> longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_NE(storage->load(longer, file.digest), Status::kOk);
}

/// The file with a new valid checksum, as another version of the program would have written it.
std::vector<std::byte> summed(std::vector<std::byte> file) {
  const std::size_t body = file.size() - std::tuple_size_v<core::Sha256Digest>;
  const core::Sha256Digest sum = core::sha256(std::span(file).first(body));
  std::transform(sum.begin(), sum.end(), file.begin() + static_cast<std::ptrdiff_t>(body),
                 [](auto byte) { return static_cast<std::byte>(byte); });
  return file;
}

// Catches a version that is read but not refused: no gains would be read, and the law would command zeros.
TEST_F(TableFile, OfAnotherVersionIsRefused) {
  RecordProperty("promise", "R10");
  ASSERT_EQ(storage->load(summed(bytes), file.digest), Status::kOk) << "the sum is made as the file's is";
  for (const std::size_t at : {8U, 9U, 10U, 11U}) {
    std::vector<std::byte> other = bytes;
    other[at] ^= std::byte{1};
    EXPECT_EQ(storage->load(summed(other), file.digest), Status::kInvalidArgument) << at;
  }
  std::vector<std::byte> other = bytes;
  other[0] ^= std::byte{1};
  EXPECT_EQ(storage->load(summed(other), file.digest), Status::kInvalidArgument) << "it is no table at all";
}

// Catches a reader that reads what fits and ignores the rest, or reads past the end.
TEST_F(TableFile, WithRowsTooManyOrTooFewIsRefused) {
  std::vector<std::byte> longer = bytes;
  longer.resize(bytes.size() + 8);
  EXPECT_EQ(storage->load(summed(longer), file.digest), Status::kInvalidArgument);
  for (const std::size_t less : {1U, 4U, 8U, 64U}) {
    std::vector<std::byte> shorter = bytes;
    shorter.resize(bytes.size() - less);
    EXPECT_EQ(storage->load(summed(shorter), file.digest), Status::kInvalidArgument) << less;
  }
}

// A file with a valid SHA-256 could still hold a tree that never ends or points outside.
TEST_F(TableFile, WithATreeThatWouldNotEndIsRefused) {
  for (const SetpointNode& bad :
       {SetpointNode{{0, 1, 1, 1, 1, 1, 1, 1}}, SetpointNode{{1, 1, 1, 1, 1, 1, 1, 0}},
        SetpointNode{{0x8003, 1, 1, 1, 1, 1, 1, 1}}, SetpointNode{{0x8000, 1, 2, 1, 1, 1, 1, 1}}}) {
    TableSet wrong = made_from(file);
    wrong.x.nodes[0] = bad;
    EXPECT_EQ(storage->load(to_file(wrong), file.digest), Status::kInvalidArgument);
  }
}

}  // namespace
}  // namespace m100::mpc
