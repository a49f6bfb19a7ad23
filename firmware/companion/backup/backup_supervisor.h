// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/backup/backup_process.h"
#include "firmware/companion/operator/operator_log.h"

namespace m100::companion {

/// Watches whether the second process would give control back if this program died; tells the operator on a change.
class BackupSupervisor {
 public:
  BackupSupervisor(BackupProcess& backup, OperatorLog& operator_log) : backup_(backup), operator_log_(operator_log) {}
  /// @returns true: it would.
  bool tick(core::TimePoint now) {
    const BackupProcess::State state = backup_.state(now);
    if (state != reported_) {
      reported_ = state;
      operator_log_.write(now, state == BackupProcess::State::kReady ? "the second process runs again"
                               : state == BackupProcess::State::kDead
                                   ? "the second process is dead: nobody gives control back if this program dies. Land"
                                   : "the second process hangs: nobody gives control back if this program dies. Land");
    }
    return state == BackupProcess::State::kReady;
  }

 private:
  BackupProcess& backup_;
  OperatorLog& operator_log_;
  BackupProcess::State reported_ = BackupProcess::State::kReady;
};

}  // namespace m100::companion
