// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/version.h"

#include "firmware/core/sha256.h"
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
  const std::string digest(core::hex(mpc::generated::kVehicleDigest).data(), 12);
  return program + " " + version() +
         "\ntables: fly uses those of --gains; the built-in ones were made from the vehicle file " + digest +
         "... (SHA-256)";
}

}  // namespace m100::companion
