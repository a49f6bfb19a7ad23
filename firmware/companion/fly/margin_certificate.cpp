// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/margin_certificate.h"

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>

#include "firmware/companion/files/text/regular_file.h"
#include "firmware/companion/files/text/text_file.h"
#include "firmware/core/sha256.h"

namespace m100::companion {
namespace {

std::string sha256_of(const std::string& bytes) {
  const auto digits = core::hex(core::sha256(std::as_bytes(std::span(bytes))));
  return {digits.begin(), digits.end()};
}

}  // namespace

std::string MarginCertificate::text() const {
  if (!void_because.empty()) {
    return path + ": void: " + void_because + "; m100-lab gains --certify makes it again";
  }
  char bound[80];
  std::snprintf(bound, sizeof bound, "peak sensitivity at most %.2f in its box, mode ", peak_sensitivity);
  return path + ": " + bound + std::string(name(mode));
}

std::optional<MarginCertificate> certificate_beside(const std::string& vehicle_path, const std::string& tables_path) {
  MarginCertificate out{.path = vehicle_path + ".certificate.json", .void_because = {}};
  if (!std::filesystem::exists(out.path)) {
    return {};
  }
  const nlohmann::json all = nlohmann::json::parse(read_file(out.path), nullptr, false);
  const nlohmann::json body = all.is_object() ? all.value("certificate", nlohmann::json()) : nlohmann::json();
  const auto word = [](const nlohmann::json& from, const char* key) {
    const auto found = from.is_object() ? from.find(key) : from.end();
    return from.is_object() && found != from.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  const auto bound = body.is_object() ? body.find("peak_sensitivity_bound") : body.end();
  const std::optional<Mode> mode = mode_named(word(body, "mode"));
  if (!mode || bound == body.end() || !bound->is_number() || word(all, "sha256") != sha256_of(body.dump())) {
    out.void_because = "not a certificate, or changed";
    return out;
  }
  out.mode = *mode;
  out.peak_sensitivity = bound->get<double>();
  if (word(body, "vehicle_sha256") != sha256_of(read_file(vehicle_path))) {
    out.void_because = "made for another vehicle file than " + vehicle_path;
  } else if (word(body, "table_sha256") != sha256_of(read_file(tables_path))) {
    out.void_because = "made for another gain table than " + tables_path;
  }
  return out;
}

}  // namespace m100::companion
