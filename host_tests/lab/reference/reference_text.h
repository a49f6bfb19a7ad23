// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <map>
#include <string>

namespace m100::lab::reference {

/// What the code's tables do not say of each reference page, by its name and as JSON: title, introduction, meanings by
/// section and key, and the rows that only the sources hold. reference_text.py makes the source from meanings.toml.
std::map<std::string, std::string> page_texts();

}  // namespace m100::lab::reference
