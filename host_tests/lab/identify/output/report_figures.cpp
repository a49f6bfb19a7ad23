// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/output/report_figures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host_tests/lab/identify/output/spectra.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::identify {
namespace {

constexpr double kHighest_hz = 5.0;
using Stretches = std::vector<std::pair<std::size_t, std::size_t>>;

/// The series of one direction of a result.
struct Direction {
  std::string name;
  const std::vector<double>& input;
  const std::vector<double>& measured;
  const std::vector<double>& declared;
  const std::vector<double>& final_model;
  const std::vector<double>& declared_residual;
  const std::vector<double>& final_residual;
};

void against_input(plot::Page& page, const Direction& d, const Stretches& pieces, double period_s) {
  constexpr double kEarliest_s = -1.0;
  constexpr double kLatest_s = 3.0;
  const auto step = static_cast<std::ptrdiff_t>(std::max(1L, std::lround(0.02 / period_s)));
  plot::Curve declared{.name = "declared model", .color = plot::kOrange};
  plot::Curve found{.name = "with the effects found", .color = plot::kBlue};
  const auto last = static_cast<std::ptrdiff_t>(std::lround(kLatest_s / period_s));
  for (auto lag = static_cast<std::ptrdiff_t>(std::lround(kEarliest_s / period_s)); lag <= last; lag += step) {
    for (plot::Curve* line : {&declared, &found}) {
      const std::vector<double>& left = line == &found ? d.final_residual : d.declared_residual;
      line->x.push_back(static_cast<double>(lag) * period_s);
      line->y.push_back(cross_correlation(d.input, left, lag, pieces));
    }
  }
  const double band =
      independent_band(d.input, d.final_residual, static_cast<std::size_t>(std::lround(2.0 / period_s)), pieces);
  page.figure(
      plot::Figure{.title = "Residual against the input" + d.name,
                   .x_label = "delay of the residual after the input [s]",
                   .y_label = "correlation",
                   .lines = {declared, found},
                   .levels = {{band, "95 % if independent"}, {-band, ""}, {0.0, ""}},
                   .height = 230},
      "Outside of the band the input predicts the residual. At negative delays no input can be the cause: there the "
      "correlation comes from a control loop that was closed in flight, or from a clock error.");
}

/// Number of bins up to kHighest_hz.
std::size_t bins_of(const Spectra& spectra) {
  return static_cast<std::size_t>(std::count_if(spectra.frequency_hz.begin(), spectra.frequency_hz.end(),
                                                [](double hz) { return hz <= kHighest_hz; }));
}

void spectrum(plot::Page& page, const Direction& d, const Stretches& pieces, double period_s) {
  plot::Figure figure{
      .title = "Power density" + d.name, .x_label = "frequency [Hz]", .y_label = "dB of unit² per Hz", .height = 260};
  const auto add = [&](const std::vector<double>& values, const char* name, const char* color) {
    const Spectra spectra = welch(values, values, pieces, period_s);
    plot::Curve line{.name = name, .color = color};
    for (std::size_t k = 0; k < bins_of(spectra); ++k) {
      line.x.push_back(spectra.frequency_hz[k]);
      line.y.push_back(10.0 * std::log10(std::max(1e-20, spectra.output[k])));
    }
    figure.lines.push_back(std::move(line));
  };
  add(d.measured, "measured", plot::kBlack);
  add(d.declared_residual, "residual, declared model", plot::kOrange);
  add(d.final_residual, "residual, with the effects found", plot::kBlue);
  page.figure(figure, "Welch's method, segments of 5 s that overlap by half.");
}

/// Gain, phase and coherence over the frequency.
struct ResponseLines {
  plot::Curve gain, phase, coherence;
};

/// @param empty  name, colour and width of the lines
ResponseLines response_lines(const Spectra& spectra, const plot::Curve& empty) {
  constexpr double kMinCoherence = 0.3;  // below it the ratio is dominated by noise
  ResponseLines out{empty, empty, empty};
  double turns = 0.0;
  double before = 0.0;
  for (std::size_t k = 0; k < bins_of(spectra); ++k) {
    const bool heard = spectra.coherence(k) > kMinCoherence;
    const double angle = std::arg(spectra.response(k)) / std::numbers::pi * 180.0;
    turns -= heard ? std::round((angle + turns - before) / 360.0) * 360.0 : 0.0;
    before = heard ? angle + turns : before;
    out.gain.x.push_back(spectra.frequency_hz[k]);
    out.gain.y.push_back(heard ? 20.0 * std::log10(std::abs(spectra.response(k))) : std::nan(""));
    out.phase.y.push_back(heard ? angle + turns : std::nan(""));
    out.coherence.y.push_back(spectra.coherence(k));
  }
  out.phase.x = out.coherence.x = out.gain.x;
  return out;
}

void response(plot::Page& page, const Direction& d, const Stretches& pieces, double period_s) {
  plot::Figure gain{.title = "Frequency response from the input" + d.name + ": gain",
                    .x_label = "frequency [Hz]",
                    .y_label = "gain [dB]",
                    .height = 230};
  plot::Figure phase{.title = "Phase", .x_label = "frequency [Hz]", .y_label = "degrees", .height = 230};
  plot::Figure agree{
      .title = "Coherence of input and response", .x_label = "frequency [Hz]", .y_label = "share", .height = 180};
  const auto add = [&](const std::vector<double>& output, const char* name, const char* color, bool data) {
    ResponseLines lines = response_lines(welch(d.input, output, pieces, period_s),
                                         {.name = name, .color = color, .width = data ? 2.4 : 1.4});
    gain.lines.push_back(std::move(lines.gain));
    phase.lines.push_back(std::move(lines.phase));
    if (data) {
      agree.lines.push_back(std::move(lines.coherence));
    }
  };
  add(d.measured, "measured", plot::kBlack, true);
  add(d.declared, "declared model", plot::kOrange, false);
  add(d.final_model, "with the effects found", plot::kBlue, false);
  agree.y_range = std::pair{0.0, 1.0};
  page.figure(gain,
              "Drawn where the coherence is above 0.3. With a dead zone the gain depends on the size of the stick "
              "movements, so the models are simulated with the sticks of the log and evaluated in the same way.");
  page.figure(phase, "Phase relative to the same input.");
  page.figure(agree, "The part below one comes from air, noise, or a cause other than this input.");
}

std::string share_text(double share) { return std::to_string(std::lround(100.0 * std::max(0.0, share))) + " %"; }

void remainder_panel(plot::Page& page, const RemainderCurve& curve, bool first, const std::string& unit) {
  plot::Curve means{.name = "means of 30 groups", .color = plot::kOrange, .width = 5.0};
  for (std::size_t k = 0; k < curve.mean_x.size(); ++k) {  // a point is a line of no length
    const double next = curve.mean_x[std::min(k + 1, curve.mean_x.size() - 1)];
    means.x.insert(means.x.end(), {curve.mean_x[k], 0.5 * (curve.mean_x[k] + next)});
    means.y.insert(means.y.end(), {curve.mean[k], std::nan("")});
  }
  const plot::Curve low{
      .name = "95 % from", .x = curve.x, .y = curve.low, .color = plot::kBlue, .width = 1.0, .dashed = true};
  plot::Curve high = low;
  high.name = "to";
  high.y = curve.high;
  const std::string shares =
      share_text(curve.predicted) + " of the remainder on unseen data; chance reaches " + share_text(curve.chance);
  page.figure(
      plot::Figure{.title = (curve.is_gain ? "Gain of the command" : "Added to the command") +
                            (curve.direction.empty() ? "" : ", direction " + curve.direction),
                   .x_label = curve.channel + (curve.unit.empty() ? "" : " [" + curve.unit + "]"),
                   .y_label = curve.is_gain ? "share of the gain" : unit,
                   .lines = {means, low, high, {.name = "curve", .x = curve.x, .y = curve.value, .width = 2.2}},
                   .levels = {{0.0, ""}},
                   .height = 250},
      curve.channel +
          (curve.predicted > curve.chance ? " predicts " + shares : " predicts no more than chance: " + shares) +
          (first ? "." : ". It predicts " + share_text(curve.after_first) + " of what the first curve leaves."));
}

}  // namespace

std::string described(const RemainderCurve& curve) {
  return (curve.is_gain ? "a gain that depends on " : "something added that depends on ") + curve.channel +
         (curve.direction.empty() ? "" : " in direction " + curve.direction);
}

void remainder_figures(plot::Page& page, const IdentifyResult& result, const std::string& unit) {
  if (result.remainder.empty()) {
    return;
  }
  page.heading("What the final model leaves");
  page.paragraph(
      "The remainder is the command that the model would need in addition to answer as measured: the inverse dynamics "
      "of the model, applied to measured minus simulated. So its cause is what a channel shows at the same moment. "
      "Each "
      "curve is judged on the fifth of the log that its fit has not seen, for every fifth in turn; those that predict "
      "most come first. Sticks are shown as late as the model's delay lets them act.");
  std::vector<std::string> drawn, more;
  page.begin_grid();
  for (const RemainderCurve& curve : result.remainder) {
    const bool is_beyond_chance = curve.predicted > curve.chance;
    if (!curve.x.empty() && (is_beyond_chance || result.verdict == "unexplained")) {
      remainder_panel(page, curve, drawn.empty(), unit);
      drawn.push_back(curve.channel);
    } else if (is_beyond_chance) {
      more.push_back(described(curve) + " " + share_text(curve.predicted));
    }
  }
  page.end_grid();
  if (drawn.empty()) {
    page.paragraph("No channel of the log predicts more of the remainder than chance reaches (" +
                   share_text(result.remainder.front().chance) + ").");
  } else if (!more.empty()) {
    page.paragraph("Also beyond chance: " + plot::joined(more, "; ") + ".");
  }
}

const Series* series_named(const IdentifyResult& result, const std::string& name) {
  for (const Series& series : result.figures.series) {
    if (series.name == name) {
      return &series;
    }
  }
  return nullptr;
}

void specialist_figures(plot::Page& page, const IdentifyResult& result) {
  const Figures& f = result.figures;
  const Stretches pieces = stretches(f.t_s, f.sample_period_s);
  for (const std::string suffix : {"", "_x", "_y", "_z"}) {
    const auto of = [&](const char* name) { return series_named(result, name + suffix); };
    const Series* input = of("input");
    if (input == nullptr || input->values.size() != f.t_s.size() || f.t_s.size() < 2) {
      continue;
    }
    const Direction d{.name = suffix.empty() ? "" : ", " + suffix.substr(1),
                      .input = input->values,
                      .measured = of("measured")->values,
                      .declared = of("declared")->values,
                      .final_model = of("final")->values,
                      .declared_residual = of("declared_residual")->values,
                      .final_residual = of("final_residual")->values};
    against_input(page, d, pieces, f.sample_period_s);
    if (welch(d.input, d.measured, pieces, f.sample_period_s).segments < 2) {
      page.paragraph("No spectrum: the ranges do not contain two stretches of 5 s.");
      continue;
    }
    spectrum(page, d, pieces, f.sample_period_s);
    response(page, d, pieces, f.sample_period_s);
  }
}

}  // namespace m100::lab::identify
