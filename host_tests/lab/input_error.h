// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/files/text/file_error.h"

namespace m100::lab {

/// Bad input of any kind: one line that names file, line and key, printed to stderr; the program then exits with 2.
using InputError = companion::FileError;

}  // namespace m100::lab
