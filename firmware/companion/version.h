// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace m100::companion {

/// "0.2.0 (commit 0123abc of 2026-01-31)", with "and changes" where the checkout had some; "0.2.0" where there is no
/// git.
std::string version();

/// What --version prints: program, version, and which tables fly.
std::string version_text(const std::string& program);

}  // namespace m100::companion
