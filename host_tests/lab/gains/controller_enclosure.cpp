// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/controller_enclosure.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace m100::lab::gains {
namespace {

using Complex = std::complex<double>;
using ComplexMatrix = Eigen::MatrixXcd;
using Row = Eigen::RowVectorXd;

/// Above any relative error of a sum of 64 products in double.
constexpr double kSlack = 1e-13;

/// A row r with r >= first + r e, by iteration; false: none was found, because e is too large.
bool radius_of(const Row& first, const Eigen::MatrixXd& e, Row& radius) {
  radius = first;
  for (int i = 0; i < 60; ++i) {
    const Row next = (1.0 + kSlack) * (first + radius * e);
    const Row tried = 1.02 * next + Row::Constant(next.size(), 1e-300);
    if ((((1.0 + kSlack) * (first + tried * e)).array() <= tried.array()).all()) {
      radius = tried;
      return true;
    }
    radius = next;
    if (!(radius.maxCoeff() < 1e30)) {
      return false;
    }
  }
  return false;
}

ComplexNumber<Enclosure> around(Complex middle, double radius) {
  return {Enclosure::outward(middle.real() - radius, middle.real() + radius),
          Enclosure::outward(middle.imag() - radius, middle.imag() + radius)};
}

/// The same controller with states in units that make rows and columns alike; powers of two, so nothing is rounded.
LiftedController balanced(LiftedController of) {
  constexpr int kRounds = 12;
  const Eigen::Index n = of.a.rows();
  for (int round = 0; round < kRounds; ++round) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const double row = of.a.row(i).cwiseAbs().sum() - std::abs(of.a(i, i)) + of.b.row(i).cwiseAbs().sum();
      const double column = of.a.col(i).cwiseAbs().sum() - std::abs(of.a(i, i)) + std::abs(of.c(i));
      if (row > 0.0 && column > 0.0) {
        const double factor = std::exp2(std::round(0.5 * std::log2(row / column)));
        of.a.row(i) /= factor;
        of.b.row(i) /= factor;
        of.a.col(i) *= factor;
        of.c(i) *= factor;
      }
    }
  }
  return of;
}

/// The controller in coordinates in which it is nearly triangular, with bounds of the rounding of each product. For any
/// matrices W and U, y = c (z - a)^-1 is r W with r (z W U - W a U) = c U, so W and U need not be exact inverses.
struct TriangularForm {
  explicit TriangularForm(const LiftedController& unbalanced) {
    const LiftedController controller = balanced(unbalanced);
    const Eigen::ComplexSchur<ComplexMatrix> schur(controller.a.cast<Complex>());
    const ComplexMatrix u = schur.matrixU(), w = u.adjoint();
    const Eigen::MatrixXd size_u = u.cwiseAbs(), size_w = w.cwiseAbs();
    unit = w * u;
    unit_error = kSlack * size_w * size_u;
    dynamics = w * controller.a.cast<Complex>() * u;
    dynamics_error = kSlack * size_w * controller.a.cwiseAbs() * size_u;
    inputs = w * controller.b.cast<Complex>();
    inputs_error = kSlack * size_w * controller.b.cwiseAbs();
    output = controller.c.transpose().cast<Complex>() * u;
    output_error = kSlack * controller.c.cwiseAbs().transpose() * size_u;
  }
  ComplexMatrix unit, dynamics, inputs;
  Eigen::RowVectorXcd output;
  Eigen::MatrixXd unit_error, dynamics_error, inputs_error;
  Row output_error;
};

/// row inputs (+ d), the row within `radius`.
std::vector<ComplexNumber<Enclosure>> times_inputs(const Eigen::RowVectorXcd& row, const Row& radius,
                                                   const TriangularForm& form, const Eigen::VectorXd* direct) {
  std::vector<ComplexNumber<Enclosure>> out;
  const Eigen::RowVectorXcd middle = row * form.inputs;
  const Row error =
      (1.0 + kSlack) * (radius * (form.inputs.cwiseAbs() + form.inputs_error) + row.cwiseAbs() * form.inputs_error +
                        kSlack * row.cwiseAbs() * form.inputs.cwiseAbs());
  for (Eigen::Index j = 0; j < middle.size(); ++j) {
    const ComplexNumber<Enclosure> sum = around(middle(j), error(j));
    out.push_back(direct == nullptr ? sum : sum + ComplexNumber<Enclosure>{(*direct)(j), 0.0});
  }
  return out;
}

struct Enclosed {
  bool valid = false;
  std::vector<ComplexNumber<Enclosure>> value, by_z;
};

/// Over all z within `reach` of z0.
Enclosed enclose(const TriangularForm& form, const LiftedController& controller, Complex z0, double reach) {
  const Eigen::Index n = form.dynamics.rows();
  const ComplexMatrix m = z0 * form.unit - form.dynamics;
  const ComplexMatrix x = m.triangularView<Eigen::Upper>().solve(ComplexMatrix::Identity(n, n));
  const Eigen::MatrixXd size = x.cwiseAbs();
  const Eigen::MatrixXd unit_size = form.unit.cwiseAbs() + form.unit_error;
  Eigen::MatrixXd e = (ComplexMatrix::Identity(n, n) - m * x).cwiseAbs();
  e += kSlack * (Eigen::MatrixXd::Identity(n, n) + m.cwiseAbs() * size);  // rounding of the product
  e += (2.0 * form.unit_error + form.dynamics_error + (1.0 + kSlack) * reach * unit_size) * size;
  const Eigen::RowVectorXcd first = form.output * x;
  const Row first_error = (kSlack * form.output.cwiseAbs() + form.output_error) * size;
  Enclosed out;
  Row radius, radius2;
  if (!radius_of((1.0 + kSlack) * (first.cwiseAbs() * e + first_error), e, radius)) {
    return out;
  }
  const Eigen::RowVectorXcd turned = first * form.unit;
  const Row turned_error = first.cwiseAbs() * (form.unit_error + kSlack * unit_size) + radius * unit_size;
  const Eigen::RowVectorXcd second = turned * x;
  const Row second_error = kSlack * turned.cwiseAbs() * size + (1.0 + kSlack) * turned_error * size;
  if (!radius_of((1.0 + kSlack) * (second.cwiseAbs() * e + second_error), e, radius2)) {
    return out;
  }
  out.valid = true;
  out.value = times_inputs(first, radius, form, &controller.d);
  out.by_z = times_inputs(-second, radius2, form, nullptr);  // the derivative of the row r is -r W U (...)^-1
  return out;
}

/// Values and derivatives as jets; dz/d angle = i (z - centre).
std::vector<ComplexNumber<LoopJet>> jets(const Enclosed& of, const ComplexNumber<LoopJet>& z) {
  std::vector<ComplexNumber<LoopJet>> out;
  const ComplexNumber<Enclosure> turn{z.re.by[kAngleVariable], z.im.by[kAngleVariable]};
  for (std::size_t k = 0; k < of.value.size(); ++k) {
    const ComplexNumber<Enclosure> slope = of.by_z[k] * turn;
    ComplexNumber<LoopJet> jet{LoopJet(of.value[k].re), LoopJet(of.value[k].im)};
    jet.re.by[kAngleVariable] = slope.re;
    jet.im.by[kAngleVariable] = slope.im;
    out.push_back(jet);
  }
  return out;
}

Complex middle_of(const ComplexNumber<LoopJet>& z) { return {z.re.value.middle(), z.im.value.middle()}; }

}  // namespace

ComplexNumber<LoopJet> point_on(const Arc& arc, const Enclosure& angle) {
  const LoopJet at = LoopJet::variable(angle, kAngleVariable);
  const ComplexNumber<LoopJet> unit{cos(at), sin(at)};
  if (arc.around_one == 0.0) {
    return unit;
  }
  return ComplexNumber<LoopJet>{LoopJet(1.0), LoopJet(0.0)} + LoopJet(arc.around_one) * unit;
}

ControllerEnclosure enclose_controller(const LiftedController& controller, const Arc& arc) {
  const ComplexNumber<LoopJet> middle = point_on(arc, Enclosure(arc.middle()));
  const ComplexNumber<LoopJet> over = point_on(arc, Enclosure(arc.low, arc.high));
  const Complex z0 = middle_of(middle);
  const double scale = arc.around_one == 0.0 ? 1.0 : arc.around_one;
  const TriangularForm form(controller);
  const Enclosed there = enclose(form, controller, z0, 1e-15);
  const Enclosed all = enclose(form, controller, z0, 0.5 * scale * (arc.high - arc.low) * (1.0 + kSlack) + 1e-15);
  ControllerEnclosure out{.valid = there.valid && all.valid, .over = {}, .middle = {}};
  if (out.valid) {
    out.over = jets(all, over);
    out.middle = jets(there, middle);
  }
  return out;
}

int eigenvalues_near_one(const LiftedController& controller, double radius) {
  constexpr int kSteps = 2000;
  double turned = 0.0;
  Complex before = 0.0;
  for (int k = 0; k <= kSteps; ++k) {
    const double angle = std::numbers::pi * k / kSteps;
    const Complex z = 1.0 + radius * std::polar(1.0, angle);
    ComplexMatrix m = -controller.a.cast<Complex>();
    m.diagonal().array() += z;
    const Eigen::PartialPivLU<ComplexMatrix> lu(m);
    const Complex determinant = lu.determinant();
    const double turn = k > 0 ? std::arg(determinant / before) : 0.0;
    if (!(std::abs(determinant) > 0.0) || !(std::abs(turn) < 0.5)) {
      return -1;
    }
    turned += turn;
    before = determinant;
  }
  const double turns = turned / std::numbers::pi;  // half the circle turns by half of 2 pi for each
  const int count = static_cast<int>(std::lround(turns));
  return std::abs(turns - count) < 1e-3 ? count : -1;
}

}  // namespace m100::lab::gains
