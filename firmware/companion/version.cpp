// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/version.h"

#include <cstdio>

#include "firmware/mpc/generated/gain_table.h"

namespace m100::companion {

// Written at every build by commit.cmake.
extern const char* const kVersionWords;
extern const char* const kCommitWords;

std::string version() {
  const std::string commit = kCommitWords;
  return std::string(kVersionWords) + (commit.empty() ? "" : " (commit " + commit + ")");
}

std::string version_text(const std::string& program) {
  std::string digest;
  for (std::size_t i = 0; i < 6; ++i) {
    char byte[3];
    std::snprintf(byte, sizeof byte, "%02x", static_cast<unsigned>(mpc::generated::kVehicleDigest[i]));
    digest += byte;
  }
  return program + " " + version() +
         "\ntables: fly uses those of --gains; the built-in ones were made from the vehicle file " + digest +
         "... (SHA-256)";
}

}  // namespace m100::companion
