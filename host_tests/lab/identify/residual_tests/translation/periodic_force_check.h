// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/identify/model/model_family.h"
#include "host_tests/lab/identify/model/translation/translation_regression.h"

namespace m100::lab::identify::translation {

/// Whether a spectral peak in the residual may be named as a periodic force: the vehicle itself must not move with that
/// period, and an oscillation fitted to the first 60 % of the training must predict the rest. A periodic force passes
/// this; an oscillation that is excited again and again does not. Preconditions: the fit is of `family`, to all blocks
/// of `training`, and has the effect, which is_periodic, with a cosine and a sine column for each horizontal axis.
bool is_periodic_force(const Family& family, const TranslationBlocks& training, const Fit& fit,
                       const model::TranslationEffect& effect);

}  // namespace m100::lab::identify::translation
