// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/backup/backup_channel.h"

namespace m100::companion {

/// The whole run of the second process.
[[noreturn]] void run_backup(int socket, const Rounds& rounds, BackupSharedState& board, hal::PortClock& clock);

}  // namespace m100::companion
