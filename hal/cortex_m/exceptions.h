// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::hal {

/// Exit status of the emulator after a fault, a trap (M100_ASSERT) or an interrupt nobody handles.
inline constexpr int kExitOfFault = 70;

}  // namespace m100::hal
