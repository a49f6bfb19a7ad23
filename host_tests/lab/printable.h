// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/files/text/printable.h"

namespace m100::lab {

using companion::printable;  // NOLINT(misc-unused-using-decls): for those who include this

}  // namespace m100::lab
