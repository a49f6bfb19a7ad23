// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <matio.h>
#include <sqlite3.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/unit/logs/ulog_bytes.h"

namespace m100::lab::logs {

// One small intact log of each format, as bytes. The damage tests damage them, and the fuzzer starts from them.

using namespace std::string_literals;

std::string raw(auto value) { return UlogBytes::raw(value); }

inline std::string csv_sample() {
  std::string out = "t_s,rc_roll,\"odom, roll\"\n";
  for (int k = 0; k < 20; ++k) {
    out += std::to_string(0.01 * k) + "," + std::to_string(1024 + k) + ",-1e-3\n";
  }
  return out;
}

inline std::string ulog_sample() {
  UlogBytes log;
  log.message('B', std::string(40, '\0'));
  log.message('F', "point:float x;float y;");
  log.message('F', "vehicle_attitude:uint64_t timestamp;float[4] q;point[2] place;uint8_t[4] _padding0;");
  log.message('I',
              "\x0d"
              "char[3] sys_name"
              "PX4");
  log.subscribe(0, 1, "vehicle_attitude");
  log.subscribe(1, 2, "vehicle_attitude");
  log.message('S', "\x2f\x73\x13\x20\x25\x0c\xbb\x12");
  for (std::uint64_t k = 0; k < 20; ++k) {
    std::string row = UlogBytes::raw(10'000 * (k + 1));
    row.append(UlogBytes::raw(1.F)).append(12, '\0').append(UlogBytes::raw(0.5F)).append(12, '\0');
    log.data(static_cast<std::uint16_t>(1 + k % 2), row);
  }
  log.message('O', UlogBytes::raw(std::uint16_t{20}));
  return log.bytes();
}

inline std::string padded(const std::string& text, std::size_t size) {
  return text + std::string(size - text.size(), '\0');
}

inline std::string definition(char type, int length, const std::string& name, const std::string& letters,
                              const std::string& labels) {
  return "\xa3\x95\x80"s + type + static_cast<char>(length) + padded(name, 4) + padded(letters, 16) +
         padded(labels, 64);
}
inline std::string record(char type, const std::string& body) { return "\xa3\x95"s + type + body; }

/// Attitude in hundredths of a degree and in float, two gyros in one message, and tables of units and multipliers.
inline std::string ardupilot_sample(int count = 40) {
  std::string out = definition('\x80', 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
  out += definition(1, 17, "ATT", "QcfB", "TimeUS,Roll,Pitch,N") + definition(2, 16, "IMU", "QBf", "TimeUS,I,GyrX");
  out += definition(3, 76, "UNIT", "QbZ", "TimeUS,Id,Label") + definition(4, 20, "MULT", "Qbd", "TimeUS,Id,Mult");
  out += definition(5, 44, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds");
  out[out.find("QcfB") - 5] = 18;  // Q8 c2 f4 B1 and three of head
  out += record(3, UlogBytes::raw(std::uint64_t{0}) + 'd' + padded("deg", 64)) +
         record(3, UlogBytes::raw(std::uint64_t{0}) + '#' + padded("instance", 64));
  out += record(4, UlogBytes::raw(std::uint64_t{0}) + 'B' + UlogBytes::raw(1e-2)) +
         record(4, UlogBytes::raw(std::uint64_t{0}) + 'A' + UlogBytes::raw(1e-1));
  out += record(5, UlogBytes::raw(std::uint64_t{0}) + '\1' + padded("sdd-", 16) + padded("FBA-", 16));
  out += record(5, UlogBytes::raw(std::uint64_t{0}) + '\2' + padded("s#E", 16) + padded("F-0", 16));
  std::uint64_t t_us = 1'000'000;
  for (int k = 0; k < count; ++k, t_us += 20'000) {
    out += record(1, UlogBytes::raw(t_us) + UlogBytes::raw(static_cast<std::int16_t>(100 * k)) +
                         UlogBytes::raw(static_cast<float>(10 * k)) + '\7');
    for (int i = 0; i < 2; ++i) {
      out += record(
          2, UlogBytes::raw(t_us + 500U) + static_cast<char>(i) + UlogBytes::raw(static_cast<float>(k + 100 * i)));
    }
  }
  return out;
}

inline std::string sized(const std::string& bytes) {
  return UlogBytes::raw(static_cast<std::uint32_t>(bytes.size())) + bytes;
}
inline std::string bag_field(const std::string& name, const std::string& value) { return sized(name + "=" + value); }
inline std::string bag_record(const std::string& header, const std::string& data) {
  return sized(header) + sized(data);
}

inline std::string rosbag_sample() {
  const std::string text =
      "Header header\nVector3 v\nfloat32[] axes\nEmpty[3] e\nstring name\n===\nMSG: std_msgs/Header\n"
      "uint32 seq\ntime stamp\nstring frame_id\n===\nMSG: geometry_msgs/Vector3\nfloat64 x\n"
      "float64 y\nfloat64 z\n===\nMSG: std_msgs/Empty\n";
  std::string inside =
      bag_record(bag_field("op", "\x07") + bag_field("conn", UlogBytes::raw(0U)) + bag_field("topic", "/a"),
                 bag_field("type", "x/A") + bag_field("message_definition", text));
  for (std::uint32_t k = 0; k < 12; ++k) {
    const std::string stamp = UlogBytes::raw(1000U) + UlogBytes::raw(10'000'000U * k);
    inside += bag_record(bag_field("op", "\x02") + bag_field("conn", UlogBytes::raw(0U)) + bag_field("time", stamp),
                         UlogBytes::raw(k) + stamp + sized("w") + UlogBytes::raw(1.0) + UlogBytes::raw(2.0) +
                             UlogBytes::raw(3.0) + UlogBytes::raw(1U) + UlogBytes::raw(0.5F) + sized("n"));
  }
  return "#ROSBAG V2.0\n" + bag_record(bag_field("op", "\x03"), "    ") +
         bag_record(bag_field("op", "\x05") + bag_field("compression", "none"), inside);
}

/// The bytes that `make` writes into the file whose name it receives.
template <typename Make>
std::string bytes_of_file(const std::string& name, Make&& make) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() / ("m100_sample_" + name);
  std::filesystem::remove(path);
  make(path.string());
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  in.close();
  std::filesystem::remove(path);
  return bytes;
}

inline std::string rosbag2_sample(const std::string& name) {
  return bytes_of_file(name + ".db3", [](const std::string& path) {
    sqlite3* base = nullptr;
    sqlite3_open(path.c_str(), &base);
    std::string text =
        "PRAGMA page_size=512;BEGIN;"
        "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT,type TEXT,serialization_format TEXT);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER,timestamp INTEGER,data BLOB);"
        "INSERT INTO topics VALUES(1,'/a','geometry_msgs/msg/QuaternionStamped','cdr');";
    for (int k = 0; k < 6; ++k) {
      text += "INSERT INTO messages(topic_id,timestamp,data) VALUES(1," + std::to_string(1000 + 10 * k) +
              "000000,X'00010000e8030000809698000200000041000000000000000000000000000000"
              "000000000000000000000000000000000000f03f');";
    }
    sqlite3_exec(base, (text + "COMMIT;").c_str(), nullptr, nullptr, nullptr);
    sqlite3_close(base);
  });
}

/// A structure that contains a vector, a matrix and a structure, as the published files do.
inline std::string mat_sample(const std::string& name, bool compressed) {
  return bytes_of_file(name + ".mat", [&](const std::string& path) {
    mat_t* const mat = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
    std::array<const char*, 3> names{"t", "w", "in"};
    std::array<const char*, 1> inner{"x"};
    std::array<std::size_t, 2> one{1, 1};
    std::vector<double> values(30);
    for (std::size_t k = 0; k < values.size(); ++k) {
      values[k] = 0.01 * static_cast<double>(k);
    }
    const auto matrix = [&](std::size_t rows, std::size_t columns) {
      std::array<std::size_t, 2> size{rows, columns};
      return Mat_VarCreate(nullptr, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size.data(), values.data(), 0);
    };
    matvar_t* const inside = Mat_VarCreateStruct("in", 2, one.data(), inner.data(), 1);
    Mat_VarSetStructFieldByName(inside, "x", 0, matrix(1, 10));
    matvar_t* const all = Mat_VarCreateStruct("E", 2, one.data(), names.data(), 3);
    Mat_VarSetStructFieldByName(all, "t", 0, matrix(1, 10));
    Mat_VarSetStructFieldByName(all, "w", 0, matrix(3, 10));
    Mat_VarSetStructFieldByName(all, "in", 0, inside);
    Mat_VarWrite(mat, all, compressed ? MAT_COMPRESSION_ZLIB : MAT_COMPRESSION_NONE);
    Mat_VarFree(all);
    Mat_Close(mat);
  });
}

/// Name and bytes of a sample of each format.
inline std::vector<std::pair<std::string, std::string>> log_samples(const std::string& name) {
  return {{"csv", csv_sample()},
          {"mat", mat_sample(name, false)},
          {"matz", mat_sample(name, true)},
          {"ulog", ulog_sample()},
          {"ardupilot", ardupilot_sample(10)},
          {"rosbag", rosbag_sample()},
          {"rosbag2", rosbag2_sample(name)}};
}

}  // namespace m100::lab::logs
