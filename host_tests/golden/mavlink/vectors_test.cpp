// SPDX-License-Identifier: BSD-3-Clause
// Golden vectors: frames made by one independent implementation and checked by a second one (the first line of the file
// names both). We must read back every field exactly and encode the same bytes again, including the signature.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <fstream>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/frames/hex.h"
#include "host_tests/shared_files.h"
#include "protocol/mavlink/messages.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/signature.h"

namespace m100::mavlink {
namespace {

std::vector<Json> read_vectors(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<Json> vectors;
  for (std::string line; std::getline(file, line);) {
    Json vector = Json::parse(line);
    if (vector.contains("hex")) {
      vectors.push_back(std::move(vector));
    }
  }
  return vectors;
}

/// The file writes 64-bit integers, and numbers that JSON cannot represent, as text.
template <typename Value>
Value value_of(const Json& written) {
  if (!written.is_string()) {
    return written.get<Value>();
  }
  const auto text = written.get<std::string>();
  if constexpr (std::is_floating_point_v<Value>) {
    return std::stof(text);
  } else if constexpr (std::is_signed_v<Value>) {
    return static_cast<Value>(std::stoll(text));
  } else {
    return static_cast<Value>(std::stoull(text));
  }
}

void expect_same(const Json& expected, float actual, std::string_view name) {
  EXPECT_EQ(std::bit_cast<std::uint32_t>(value_of<float>(expected)) & (std::isnan(actual) ? 0x7F800000U : ~0U),
            std::bit_cast<std::uint32_t>(actual) & (std::isnan(actual) ? 0x7F800000U : ~0U))
      << name;
}

template <typename Value>
void expect_same(const Json& expected, Value actual, std::string_view name) {
  EXPECT_EQ(value_of<Value>(expected), actual) << name;
}

template <typename Value, std::size_t kCount>
void expect_same(const Json& expected, const std::array<Value, kCount>& actual, std::string_view name) {
  if constexpr (std::is_same_v<Value, char>) {
    const std::string padded(actual.data(), actual.size());
    EXPECT_EQ(expected.get<std::string>(), padded.substr(0, padded.find('\0'))) << name;
  } else {
    ASSERT_EQ(expected.size(), kCount) << name;
    for (std::size_t i = 0; i < kCount; ++i) {
      expect_same(expected[i], actual[i], name);
    }
  }
}

Key key_of(const Json& vector) {
  const std::vector<std::byte> bytes = lab::from_hex(vector.at("key_hex").get<std::string>()).value();
  Key key{};
  EXPECT_EQ(bytes.size(), key.size());
  std::copy_n(bytes.begin(), std::min(bytes.size(), key.size()), key.begin());
  return key;
}

/// Decodes every field and encodes the same frame again. @returns false: the frame is of another type.
template <typename Message>
bool check_as(const Json& vector, const FrameView& frame) {
  if (!is<Message>(frame)) {
    return false;
  }
  EXPECT_EQ(vector.at("crc_extra").get<int>(), Message::kInfo.crc_extra);
  EXPECT_EQ(vector.at("payload_full").get<int>(), Message::kInfo.full_bytes);
  EXPECT_EQ(vector.at("payload_min").get<int>(), Message::kInfo.min_bytes);
  const auto message = decode<Message>(frame);
  std::size_t fields = 0;
  for_each_field<Message>([&](const auto& one) {
    ++fields;
    ASSERT_TRUE(vector.at("fields").contains(one.name)) << one.name;
    expect_same(vector.at("fields").at(std::string(one.name)), message.*(one.member), one.name);
  });
  EXPECT_EQ(fields, vector.at("fields").size());
  Frame again = encode(message, frame.from, frame.sequence);
  if (vector.at("signed").get<bool>()) {
    const Key key = key_of(vector);
    EXPECT_TRUE(is_signed_with(frame, key));
    EXPECT_EQ(signature_of(frame).time, vector.at("timestamp").get<std::uint64_t>());
    EXPECT_EQ(signature_of(frame).link, vector.at("link_id").get<int>());
    sign(again, key, signature_of(frame).link, signature_of(frame).time);
  }
  // For a payload of zeros the maker of the vectors sends no byte; the C library and we send one.
  const char* const wanted = vector.contains("hex_c_library_v2") ? "hex_c_library_v2" : "hex";
  EXPECT_EQ(lab::to_hex(again.bytes()), vector.at(wanted).get<std::string>());
  return true;
}

struct Count {
  std::size_t typed = 0;
  std::size_t signed_frames = 0;  ///< among the typed frames
};

/// The bytes of a vector must be exactly one frame with the content that the vector states.
void expect_read(const Json& vector, const std::string& bytes, Count& count) {
  Parser parser;
  std::size_t found = 0;
  parser.consume(lab::from_hex(bytes).value(), [&](const FrameView& frame) {
    ++found;
    EXPECT_EQ(frame.id, vector.at("msgid").get<std::uint32_t>());
    EXPECT_EQ(frame.from, (Address{vector.at("sysid").get<std::uint8_t>(), vector.at("compid").get<std::uint8_t>()}));
    EXPECT_EQ(frame.sequence, vector.at("seq").get<int>());
    EXPECT_EQ(frame.is_signed, vector.at("signed").get<bool>());
    bool known = false;
    for_each_message([&]<typename Message>() { known = check_as<Message>(vector, frame) || known; });
    count.typed += known ? 1U : 0U;
    count.signed_frames += frame.is_signed && known ? 1U : 0U;
  });
  EXPECT_EQ(found, 1U);
  EXPECT_EQ(parser.stats().bytes_dropped, 0U);
}

TEST(MavlinkVectors, EveryFrameIsReadFieldByFieldAndMadeAgain) {
  M100_SHARED_FILE_OR_SKIP(path, "protocol/mavlink_vectors.jsonl");
  Count count;
  const std::vector<Json> vectors = read_vectors(path);
  for (const Json& vector : vectors) {
    SCOPED_TRACE(vector.at("name").get<std::string>() + " " + vector.at("variant").get<std::string>());
    for (const char* const form : {"hex", "hex_c_library_v2"}) {
      if (vector.contains(form)) {
        expect_read(vector, vector.at(form).get<std::string>(), count);
      }
    }
  }
  EXPECT_EQ(vectors.size(), 204U);
  EXPECT_GE(count.typed, 19U * 6U) << "every type of ours, in each of its six forms";
  EXPECT_GE(count.signed_frames, 19U * 2U);
}

// Catches a parser that loses or invents a frame when a stream of consecutive frames is cut into portions.
TEST(MavlinkVectors, AllFramesInOneStreamAreFoundHoweverItIsCut) {
  M100_SHARED_FILE_OR_SKIP(path, "protocol/mavlink_vectors.jsonl");
  std::vector<std::byte> stream;
  for (const Json& vector : read_vectors(path)) {
    const std::vector<std::byte> frame = lab::from_hex(vector.at("hex").get<std::string>()).value();
    stream.insert(stream.end(), frame.begin(), frame.end());
  }
  for (const std::size_t portion : {std::size_t{1}, std::size_t{7}, std::size_t{64}, std::size_t{511}, stream.size()}) {
    Parser parser;
    std::size_t found = 0;
    for (std::size_t at = 0; at < stream.size(); at += portion) {
      parser.consume(std::span(stream).subspan(at, std::min(portion, stream.size() - at)),
                     [&](const FrameView&) { ++found; });
    }
    EXPECT_EQ(found, 204U) << portion;
    EXPECT_EQ(parser.stats().bytes_dropped, 0U);
  }
}

}  // namespace
}  // namespace m100::mavlink
