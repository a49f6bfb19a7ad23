// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/setpoint/linear_program.h"

#include <glpk.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numeric>

#include "firmware/core/assert.h"

namespace m100::lab::gains {
namespace {

/// The solver's column of parameter i; columns count from 1. The last column is the radius of a ball.
int column(Eigen::Index i) { return static_cast<int>(i) + 1; }

}  // namespace

Polytope::Polytope(std::size_t dimensions, ComputeBudget& budget)
    : program_(glp_create_prob()), budget_(budget), dimensions_(dimensions) {
  M100_ASSERT(dimensions > 0);
  // GLPK keeps an environment for each thread, which is freed when the thread ends.
  thread_local const std::shared_ptr<void> environment(nullptr, [](void*) { glp_free_env(); });
  glp_term_out(GLP_OFF);
  glp_set_obj_dir(program_, GLP_MAX);
  glp_add_cols(program_, static_cast<int>(dimensions) + 1);
  for (std::size_t i = 0; i < dimensions; ++i) {
    glp_set_col_bnds(program_, static_cast<int>(i) + 1, GLP_DB, -1.0, 1.0);
  }
  glp_set_col_bnds(program_, static_cast<int>(dimensions) + 1, GLP_FX, 0.0, 0.0);
}
Polytope::~Polytope() { glp_delete_prob(program_); }

/// @param ball coefficient of the ball's radius: 1, since |a| = 1; 0: the row bounds its centre alone
void Polytope::put_row(int row, const HalfSpace& half_space, double ball) {
  std::vector<int> index(dimensions_ + 2);
  std::iota(index.begin(), index.end(), 0);
  std::vector<double> value(1, 0.0);
  value.insert(value.end(), half_space.a.begin(), half_space.a.end());
  value.push_back(ball);
  glp_set_mat_row(program_, row, static_cast<int>(dimensions_) + (ball != 0.0 ? 1 : 0), index.data(), value.data());
}

void Polytope::add(const HalfSpace& half_space) {
  M100_ASSERT(half_space.a.size() == static_cast<Eigen::Index>(dimensions_));
  const int row = glp_add_rows(program_, 1);
  put_row(row, half_space, 1.0);
  glp_set_row_bnds(program_, row, GLP_UP, 0.0, half_space.b);
  rows_.push_back(half_space);
}

int Polytope::solve(double decision) {
  budget_.program();
  glp_smcp settings;
  glp_init_smcp(&settings);
  settings.msg_lev = GLP_MSG_OFF;
  settings.it_lim = ComputeBudget::kPivots;
  if (glp_simplex(program_, &settings) != 0) {
    glp_std_basis(program_);
    glp_simplex(program_, &settings);
  }
  if (glp_get_status(program_) == GLP_OPT && std::abs(glp_get_obj_val(program_) - decision) > 1e-8) {
    return GLP_OPT;
  }
  if (glp_exact(program_, &settings) == GLP_EITLIM) {
    throw ComputeBudget::Exhausted{};
  }
  return glp_get_status(program_);
}

double Polytope::maximise(const Eigen::VectorXd& a, double decision, Eigen::VectorXd* where) {
  M100_ASSERT(a.size() == static_cast<Eigen::Index>(dimensions_));
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    glp_set_obj_coef(program_, column(i), a(i));
  }
  glp_set_obj_coef(program_, static_cast<int>(dimensions_) + 1, 0.0);
  if (solve(decision) != GLP_OPT) {
    return -std::numeric_limits<double>::infinity();
  }
  if (where != nullptr) {
    where->resize(static_cast<Eigen::Index>(dimensions_));
    for (Eigen::Index i = 0; i < where->size(); ++i) {
      (*where)(i) = glp_get_col_prim(program_, column(i));
    }
  }
  return glp_get_obj_val(program_);
}

double Polytope::radius(Eigen::VectorXd* centre, std::size_t on) {
  const int ball = static_cast<int>(dimensions_) + 1;
  glp_set_col_bnds(program_, ball, GLP_DB, -10.0, 1.0);
  if (on != SIZE_MAX) {
    glp_set_row_bnds(program_, static_cast<int>(on) + 1, GLP_FX, rows_.at(on).b, rows_.at(on).b);
    put_row(static_cast<int>(on) + 1, rows_.at(on), 0.0);
  }
  Eigen::VectorXd zero = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(dimensions_));
  for (Eigen::Index i = 0; i < zero.size(); ++i) {
    glp_set_obj_coef(program_, column(i), 0.0);
  }
  glp_set_obj_coef(program_, ball, 1.0);
  const double radius = solve(1e300) == GLP_OPT ? glp_get_obj_val(program_) : -1.0;
  if (centre != nullptr) {
    centre->resize(zero.size());
    for (Eigen::Index i = 0; i < zero.size(); ++i) {
      (*centre)(i) = glp_get_col_prim(program_, column(i));
    }
  }
  if (on != SIZE_MAX) {
    put_row(static_cast<int>(on) + 1, rows_.at(on), 1.0);
    glp_set_row_bnds(program_, static_cast<int>(on) + 1, GLP_UP, 0.0, rows_.at(on).b);
  }
  glp_set_col_bnds(program_, ball, GLP_FX, 0.0, 0.0);
  return radius;
}

double Polytope::reach_beyond(std::size_t i, const Eigen::VectorXd& inside) const {
  const Eigen::VectorXd& way = rows_.at(i).a;
  double reach = ((1.0 - way.cwiseSign().cwiseProduct(inside).array()) / way.cwiseAbs().array().max(1e-300)).minCoeff();
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    if (const double slope = rows_[k].a.dot(way); k != i && slope > 0.0) {
      reach = std::min(reach, (rows_[k].b - rows_[k].a.dot(inside)) / slope);
    }
  }
  return reach - (rows_[i].b - way.dot(inside));
}

bool Polytope::is_facet(std::size_t i, const Eigen::VectorXd& inside) {
  constexpr double kClear = 1e-6;  // ten times the tolerance of the linear programs
  if (reach_beyond(i, inside) > kClear) {
    return true;
  }
  const HalfSpace& row = rows_.at(i);
  glp_set_row_bnds(program_, static_cast<int>(i) + 1, GLP_UP, 0.0, row.b + 1.0);
  const double reach = maximise(row.a, row.b);
  glp_set_row_bnds(program_, static_cast<int>(i) + 1, GLP_UP, 0.0, row.b);
  return reach > row.b + 1e-9;
}

}  // namespace m100::lab::gains
