// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "host_tests/lab/logs/formats/mat_file.h"

namespace m100::lab::logs {

/// Whether these first bytes are those of a MATLAB 7.3 file, which is HDF5 behind a header of 512 bytes.
bool is_mat_7_3(std::string_view head);

/// The real matrices and scalar structures of a MATLAB 7.3 file, read by libmatio if it was there at build time.
/// @param bytes  the whole file. @param memory  receives the numbers. @param room  bytes that they may take together.
/// @throws InputError: the file is cut off or damaged, or this build cannot read it; the message says how to save it.
std::vector<MatVariable> read_mat_7_3(const std::string& file, std::string_view bytes, std::deque<std::string>& memory,
                                      std::size_t room);

}  // namespace m100::lab::logs
