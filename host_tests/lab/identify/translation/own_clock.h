// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/identify/search/family.h"
#include "host_tests/lab/identify/translation/translation_regression.h"

namespace m100::lab::identify::translation {

/// Whether a force with a clock of its own may be claimed although its line is there: the vehicle itself does not move
/// with that period, and a line fitted to the first part of the training predicts the rest. A force with its own clock
/// does that; what swings and is shaken anew does not.
/// Preconditions: the fit is of `family`, to all blocks of `training`, and has the effect; the effect has `own_clock`
/// and two columns, cosine and sine, for each horizontal axis.
bool has_own_clock(const Family& family, const TranslationBlocks& training, const Fit& fit,
                   const model::TranslationEffect& effect);

}  // namespace m100::lab::identify::translation
