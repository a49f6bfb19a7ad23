// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "firmware/companion/files/mode.h"

namespace m100::companion {

/// A certificate of m100-lab gains --certify, found beside the vehicle file as FILE.certificate.json.
struct MarginCertificate {
  std::string path;
  std::string void_because;  ///< empty: it holds for these files
  Mode mode = Mode::kField;
  double peak_sensitivity = 0.0;

  /// One sentence: what it proves, or why it is void.
  std::string text() const;
};

/// The certificate beside the vehicle file, checked against the bytes of this file and of the tables; nullopt: there is
/// none.
std::optional<MarginCertificate> certificate_beside(const std::string& vehicle_path, const std::string& tables_path);

}  // namespace m100::companion
