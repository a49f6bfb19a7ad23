// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/excitation_result.h"

#include <string>

namespace m100::companion {

Json to_json(const ctl::Excitation<double>& excitation, const ExcitationFile& file) {
  using State = ctl::Excitation<double>::State;
  const bool is_over = excitation.state() == State::kOver;
  const bool is_aborted = excitation.state() == State::kAborted;
  Json out{{"pieces", file.pieces.size()},
           {"flown", excitation.piece()},
           {"length_s", file.length_s()},
           {"from_s", core::seconds<double>(excitation.began().time_since_epoch())},
           {"to_s", core::seconds<double>(excitation.ended().time_since_epoch())},
           {"over", is_over},
           {"aborted", is_aborted}};
  if (is_aborted) {
    out["abort"] = {{"why", std::string(ctl::Excitation<double>::name(excitation.abort()))},
                    {"axis", std::string(name(excitation.axis()))},
                    {"distance", excitation.distance()},
                    {"speed", excitation.speed()}};
  }
  return out;
}

}  // namespace m100::companion
