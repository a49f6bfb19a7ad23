// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace m100::companion {

/// "0.2.0 (commit 0123abc of 2026-01-31)", with "and changes" if the checkout had some; "0.2.0" without git.
std::string version();

/// The text of --version: program, version, and which tables fly.
std::string version_text(const std::string& program);

}  // namespace m100::companion
