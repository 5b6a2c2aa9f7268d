// SPDX-License-Identifier: LGPL-2.1-or-later
#include "time_series.h"

#include <feib/expression.h>
#include <feib/message.h>

#include <muParser.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <sstream>

namespace feib
{
  namespace
  {
    const std::vector<std::string> space_names     = {"x", "y", "z"};
    const std::vector<std::string> reference_names = {"s1", "s2", "s3"};


    /// A parser that knows the functions.
    mu::Parser
    make_parser()
    {
      mu::Parser parser;
      parser.ClearConst();
      parser.DefineFun(
        "if", +[](const double c, const double a, const double b) { return c != 0 ? a : b; });
      parser.DefineFun(
        "pow", +[](const double a, const double b) { return std::pow(a, b); });
      parser.DefineFun(
        "mod", +[](const double a, const double b) { return a - b * std::floor(a / b); });
      parser.DefineFun(
        "floor", +[](const double a) { return std::floor(a); });
      parser.DefineFun(
        "ceil", +[](const double a) { return std::ceil(a); });
      parser.DefineFun(
        "erf", +[](const double a) { return std::erf(a); });
      parser.DefineFun(
        "ramp", +[](const double a) {
          return a <= 0 ? 0. : a >= 1 ? 1. : (1 - std::cos(M_PI * a)) / 2;
        });
      return parser;
    }


    /// The same with the constants and series of a case, which must live as long.
    mu::Parser
    make_parser(const Parameters &parameters)
    {
      mu::Parser parser = make_parser();
      for (const auto &[name, value] : parameters.constants())
        parser.DefineConst(name, value);
      for (const auto &[name, series] : parameters.series())
        parser.DefineFunUserData(
          name,
          +[](void *series, const double t) {
            return (*static_cast<const TimeSeries *>(series))(t);
          },
          const_cast<TimeSeries *>(series.get()));
      return parser;
    }


    [[noreturn]] void
    refuse(const Parameters &parameters,
           const std::string &place,
           const std::string &text,
           std::string problem,
           const std::vector<std::string> &variables)
    {
      while (!problem.empty() && (problem.back() == '.' || problem.back() == '\n'))
        problem.pop_back();
      std::string known;
      for (const std::string &name : variables)
        known += (known.empty() ? "" : ", ") + name;
      for (const auto &[name, value] : parameters.constants())
        known += ", " + name;
      parameters.fail(place,
                      "the expression \"" + text + "\" cannot be read: " + problem +
                        "; variables and constants are " + known);
    }


    /// What muParser takes and no one can have meant: several results, assignments.
    std::string
    misuse(const mu::Parser &parser, const std::string &text)
    {
      if (parser.GetNumResults() > 1)
        return "it has several results";
      for (std::size_t i = text.find('='); i != std::string::npos; i = text.find('=', i + 1))
        {
          const bool comparison =
            (i > 0 && std::string("<>!=").find(text[i - 1]) != std::string::npos) ||
            (i + 1 < text.size() && text[i + 1] == '=');
          if (!comparison)
            return "= assigns; to compare write ==";
        }
      return "";
    }


    /// The place of component i; one expression may stand alone, without an array around it.
    std::string
    place(const std::string &key, const std::size_t i, const std::size_t n)
    {
      return n == 1 ? key : key + "/" + std::to_string(i);
    }


    /// Not for concurrent use: the variables are members.
    template <int dim>
    class ExpressionFunction : public Expressions<dim>
    {
    public:
      ExpressionFunction(const Parameters &parameters,
                         const std::string &key,
                         const std::vector<std::string> &texts,
                         const Variables variables)
        : Expressions<dim>(texts.size())
        , variables(variables)
        , has_time(variables != Variables::reference)
        , components(texts.size())
        , series(parameters.series())
      {
        const auto &all = variables == Variables::space_time ? space_names : reference_names;
        std::vector<std::string> names;
        if (variables != Variables::time)
          names.assign(all.begin(), all.begin() + dim);
        if (has_time)
          names.push_back("t");
        values.fill(0.);
        for (std::size_t i = 0; i < texts.size(); ++i)
          {
            components[i].pointer = parameters.pointer() + "/" + place(key, i, texts.size());
            components[i].text    = texts[i];
            mu::Parser &parser    = components[i].parser;
            parser                = make_parser(parameters);
            std::string problem;
            try
              {
                for (const std::string &name : names)
                  parser.DefineVar(name,
                                   name == "t" ? &values[dim] : &values[&name - names.data()]);
                parser.SetExpr(texts[i]);
                components[i].constant = parser.GetUsedVar().empty();
                components[i].value    = parser.Eval();
                problem                = misuse(parser, texts[i]);
              }
            catch (const mu::Parser::exception_type &failure)
              {
                problem = failure.GetMsg();
              }
            if (!problem.empty())
              refuse(parameters, place(key, i, texts.size()), texts[i], problem, names);
          }
      }

      double
      value(const dealii::Point<dim> &p, const unsigned int component = 0) const override
      {
        set_variables(p);
        return evaluate(p, component);
      }

      void
      vector_value(const dealii::Point<dim> &p, dealii::Vector<double> &result) const override
      {
        set_variables(p);
        for (unsigned int i = 0; i < components.size(); ++i)
          result[i] = evaluate(p, i);
      }

      Issues not_finite(MPI_Comm communicator) override;

    private:
      /// Squares of values, times lengths and masses, stay finite.
      static constexpr double largest = 1e100;

      /// Where a component is not finite, or too large.
      struct Trouble
      {
        std::array<double, dim> place;
        double time, value;
      };

      struct Component
      {
        std::string pointer, text;
        mu::Parser parser;
        bool constant;
        double value; // when constant
        std::optional<Trouble> trouble;
      };

      const Variables variables;
      const bool has_time;
      mutable std::array<double, dim + 1> values; // the parsers hold pointers to them
      mutable std::vector<Component> components;
      const std::map<std::string, std::shared_ptr<const TimeSeries>> series; // in the parsers

      void
      set_variables(const dealii::Point<dim> &p) const
      {
        for (unsigned int d = 0; d < dim; ++d)
          values[d] = p[d];
        if (has_time)
          values[dim] = this->get_time();
      }

      double
      evaluate(const dealii::Point<dim> &p, const unsigned int i) const
      {
        Component &component = components[i];
        const double result  = component.constant ? component.value : component.parser.Eval();
        if (!(std::abs(result) <= largest))
          {
            Trouble trouble{{}, this->get_time(), result};
            std::copy(p.begin_raw(), p.end_raw(), trouble.place.begin());
            if (!component.trouble || trouble.place < component.trouble->place)
              component.trouble = trouble;
          }
        return result;
      }
    };


    template <int dim>
    Issues
    ExpressionFunction<dim>::not_finite(const MPI_Comm communicator)
    {
      bool any = false;
      for (const Component &component : components)
        any = any || component.trouble;
      Issues issues;
      if (dealii::Utilities::MPI::max(int(any), communicator) == 0)
        return issues;
      for (Component &component : components)
        {
          std::vector<double> mine; // place, time, value
          if (component.trouble)
            {
              mine.assign(component.trouble->place.begin(), component.trouble->place.end());
              mine.push_back(component.trouble->time);
              mine.push_back(component.trouble->value);
            }
          component.trouble.reset();
          std::vector<double> first;
          for (const auto &one : dealii::Utilities::MPI::all_gather(communicator, mine))
            if (!one.empty() &&
                (first.empty() || std::lexicographical_compare(one.begin(),
                                                               one.begin() + dim,
                                                               first.begin(),
                                                               first.begin() + dim)))
              first = one;
          if (first.empty())
            continue;
          std::ostringstream message;
          const double value = first[dim + 1];
          message << '"' << component.text << "\" is "
                  << (std::isnan(value) ? "nan" : readable(value))
                  << (variables == Variables::space_time ? " at ("
                      : variables == Variables::time     ? " at "
                                                         : " at the reference place (");
          for (unsigned int a = 0; a < dim && variables != Variables::time; ++a)
            message << (a > 0 ? ", " : "") << first[a] << (a + 1 == dim ? ")" : "");
          if (has_time)
            message << (variables == Variables::time ? "time " : " and time ") << first[dim];
          message << "; it must be "
                  << (std::isfinite(value) ? "at most " + readable(largest) + " in size" : "finite")
                  << " there";
          issues.push_back({component.pointer, message.str()});
        }
      return issues;
    }
  } // namespace


  template <int dim>
  std::unique_ptr<Expressions<dim>>
  parse_expressions(const Parameters &parameters,
                    const std::string &key,
                    const unsigned int n_components,
                    const Variables variables)
  {
    const std::vector<std::string> texts = parameters.expressions(key);
    if (texts.size() != n_components)
      parameters.fail(key,
                      "must have " + std::to_string(n_components) + " expressions, found " +
                        std::to_string(texts.size()));
    return std::make_unique<ExpressionFunction<dim>>(parameters, key, texts, variables);
  }


  bool
  depends_on_time(const Parameters &parameters, const std::string &key)
  {
    const auto texts = parameters.expressions(key);
    for (std::size_t i = 0; i < texts.size(); ++i)
      {
        mu::Parser parser = make_parser(parameters);
        try
          {
            parser.SetExpr(texts[i]);
            if (parser.GetUsedVar().count("t") != 0)
              return true;
          }
        catch (const mu::Parser::exception_type &failure)
          {
            refuse(parameters,
                   place(key, i, texts.size()),
                   texts[i],
                   failure.GetMsg(),
                   {"x", "y", "z", "t"});
          }
      }
    return false;
  }


  bool
  is_expression_word(const std::string &name)
  {
    static const mu::Parser parser = make_parser();
    return name == "pi" || name == "e" || name == "t" ||
           std::find(space_names.begin(), space_names.end(), name) != space_names.end() ||
           std::find(reference_names.begin(), reference_names.end(), name) !=
             reference_names.end() ||
           parser.GetFunDef().count(name) != 0;
  }


  template std::unique_ptr<Expressions<2>>
  parse_expressions<2>(const Parameters &, const std::string &, unsigned int, Variables);
  template std::unique_ptr<Expressions<3>>
  parse_expressions<3>(const Parameters &, const std::string &, unsigned int, Variables);
} // namespace feib
