// SPDX-License-Identifier: LGPL-2.1-or-later
#include <feib/expression.h>

#include <muParser.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace feib
{
  namespace
  {
    const std::vector<std::string> space_names     = {"x", "y", "z"};
    const std::vector<std::string> reference_names = {"s1", "s2", "s3"};


    /// A parser that knows the functions, pi and e, and nothing else.
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
    class ExpressionFunction : public dealii::Function<dim>
    {
    public:
      ExpressionFunction(const Parameters &parameters,
                         const std::string &key,
                         const std::vector<std::string> &texts,
                         const Variables variables)
        : dealii::Function<dim>(texts.size())
        , has_time(variables == Variables::space_time)
        , components(texts.size())
      {
        const auto &all = has_time ? space_names : reference_names;
        std::vector<std::string> names(all.begin(), all.begin() + dim);
        if (has_time)
          names.push_back("t");
        values.fill(0.);
        for (std::size_t i = 0; i < texts.size(); ++i)
          {
            mu::Parser &parser = components[i].parser;
            parser             = make_parser();
            std::string problem;
            try
              {
                for (const auto &[name, value] : parameters.constants())
                  parser.DefineConst(name, value);
                for (std::size_t j = 0; j < names.size(); ++j)
                  parser.DefineVar(names[j], &values[j]);
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
        return evaluate(component);
      }

      void
      vector_value(const dealii::Point<dim> &p, dealii::Vector<double> &result) const override
      {
        set_variables(p);
        for (unsigned int i = 0; i < components.size(); ++i)
          result[i] = evaluate(i);
      }

    private:
      struct Component
      {
        mu::Parser parser;
        bool constant;
        double value; // when constant
      };

      const bool has_time;
      mutable std::array<double, dim + 1> values; // the parsers hold pointers to them
      std::vector<Component> components;

      void
      set_variables(const dealii::Point<dim> &p) const
      {
        for (unsigned int d = 0; d < dim; ++d)
          values[d] = p[d];
        if (has_time)
          values[dim] = this->get_time();
      }

      double
      evaluate(const unsigned int i) const
      {
        return components[i].constant ? components[i].value : components[i].parser.Eval();
      }
    };
  } // namespace


  template <int dim>
  std::unique_ptr<dealii::Function<dim>>
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
        mu::Parser parser = make_parser();
        for (const auto &[name, value] : parameters.constants())
          parser.DefineConst(name, value);
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


  template std::unique_ptr<dealii::Function<2>>
  parse_expressions<2>(const Parameters &, const std::string &, unsigned int, Variables);
  template std::unique_ptr<dealii::Function<3>>
  parse_expressions<3>(const Parameters &, const std::string &, unsigned int, Variables);
} // namespace feib
