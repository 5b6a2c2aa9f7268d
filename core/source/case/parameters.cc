// SPDX-License-Identifier: LGPL-2.1-or-later
#include "json.h"

#include <feib/message.h>
#include <feib/registry.h>

#include <cmath>
#include <filesystem>
#include <limits>

namespace feib
{
  namespace
  {
    [[noreturn]] void
    misuse(const Parameters::Node &node, const std::string &key, const std::string &problem)
    {
      throw std::logic_error("a component asks for " + node.pointer + "/" + key + ", which " +
                             problem + "; does its schema say otherwise?");
    }


    const Json &
    member(const Parameters::Node &node, const std::string &key)
    {
      const Json::json_pointer place("/" + key);
      if (!node.value->contains(place))
        misuse(node, key, "does not exist");
      return node.value->at(place);
    }


    double
    to_number(const Parameters::Node &node, const std::string &key, const Json &value)
    {
      if (!value.is_number())
        misuse(node, key, "is not a number");
      return value.get<double>();
    }


    int
    to_integer(const Parameters::Node &node, const std::string &key, const Json &value)
    {
      const bool is_whole =
        value.is_number() && std::trunc(value.get<double>()) == value.get<double>();
      if (!is_whole)
        misuse(node, key, "is not an integer");
      const double wide = value.get<double>();
      if (wide > std::numeric_limits<int>::max() || wide < std::numeric_limits<int>::min())
        throw Error(node.pointer + pointer_part(key),
                    "must be an integer from -2147483648 to 2147483647, found " + value.dump());
      return value.get<int>();
    }


    const Json &
    array(const Parameters::Node &node, const std::string &key)
    {
      const Json &value = member(node, key);
      if (!value.is_array())
        misuse(node, key, "is not an array");
      return value;
    }
  } // namespace


  Parameters::Parameters(std::shared_ptr<const Node> node)
    : node(std::move(node))
  {}


  double
  Parameters::number(const std::string &key) const
  {
    return to_number(*node, key, member(*node, key));
  }


  int
  Parameters::integer(const std::string &key) const
  {
    return to_integer(*node, key, member(*node, key));
  }


  bool
  Parameters::boolean(const std::string &key) const
  {
    const Json &value = member(*node, key);
    if (!value.is_boolean())
      misuse(*node, key, "is not true or false");
    return value.get<bool>();
  }


  std::string
  Parameters::string(const std::string &key) const
  {
    const Json &value = member(*node, key);
    if (!value.is_string())
      misuse(*node, key, "is not a string");
    return value.get<std::string>();
  }


  std::string
  Parameters::word(const std::string &key) const
  {
    const std::string letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
    const std::string text    = string(key);
    if (text.empty() || text.find_first_not_of(letters) != std::string::npos)
      fail(key,
           "must be made of letters, digits and _, as results are named by it; found \"" + text +
             "\"");
    // Files are named by it.
    if (text.size() > 100)
      fail(key,
           "has " + std::to_string(text.size()) + " characters, at most 100 are allowed: \"" +
             readable(text, 40) + "\"");
    return text;
  }


  std::vector<double>
  Parameters::numbers(const std::string &key) const
  {
    std::vector<double> result;
    for (const Json &value : array(*node, key))
      result.push_back(to_number(*node, key, value));
    return result;
  }


  std::vector<int>
  Parameters::integers(const std::string &key) const
  {
    std::vector<int> result;
    for (const Json &value : array(*node, key))
      result.push_back(to_integer(*node, key, value));
    return result;
  }


  std::vector<std::string>
  Parameters::expressions(const std::string &key) const
  {
    const auto text = [&](const Json &value) {
      if (!value.is_number() && !value.is_string())
        misuse(*node, key, "is not an expression");
      return value.is_string() ? value.get<std::string>() : value.dump();
    };
    const Json &value = member(*node, key);
    std::vector<std::string> result;
    if (value.is_array())
      for (const Json &entry : value)
        result.push_back(text(entry));
    else
      result.push_back(text(value));
    return result;
  }


  bool
  Parameters::has(const std::string &key) const
  {
    return node->value->contains(Json::json_pointer("/" + key));
  }


  Parameters
  Parameters::child(const std::string &key) const
  {
    const Json &value = member(*node, key);
    if (!value.is_object())
      misuse(*node, key, "is not an object");
    return Parameters(std::make_shared<Node>(
      Node{node->document, &value, node->pointer + pointer_part(key), node->cell_edge}));
  }


  std::vector<Parameters>
  Parameters::children(const std::string &key) const
  {
    const Json &values = array(*node, key);
    std::vector<Parameters> result;
    for (std::size_t i = 0; i < values.size(); ++i)
      {
        if (!values[i].is_object())
          misuse(*node, key, "holds something that is not an object");
        result.emplace_back(
          std::make_shared<Node>(Node{node->document,
                                      &values[i],
                                      node->pointer + pointer_part(key) + "/" + std::to_string(i),
                                      node->cell_edge}));
      }
    return result;
  }


  std::pair<std::string, Parameters>
  Parameters::choice() const
  {
    if (!node->value->is_object() || node->value->size() != 1)
      throw std::logic_error(node->pointer + " is not a choice: an object with exactly one key");
    const std::string name = node->value->begin().key();
    return {name, child(name)};
  }


  const std::string &
  Parameters::pointer() const
  {
    return node->pointer;
  }


  double
  Parameters::cell_edge() const
  {
    return node->cell_edge;
  }


  Parameters
  Parameters::beside_cells(const double edge) const
  {
    Node result      = *node;
    result.cell_edge = edge;
    return Parameters(std::make_shared<Node>(std::move(result)));
  }


  const std::map<std::string, double> &
  Parameters::constants() const
  {
    return node->document->constants;
  }


  const std::map<std::string, std::shared_ptr<const TimeSeries>> &
  Parameters::series() const
  {
    return node->document->series;
  }


  const std::string &
  Parameters::directory() const
  {
    return node->document->directory;
  }


  std::string
  Parameters::path(const std::string &key) const
  {
    const std::string name = string(key);
    return (std::filesystem::path(directory()) / name).string();
  }


  MPI_Comm
  Parameters::communicator() const
  {
    return node->document->communicator;
  }


  void
  Parameters::fail(const std::string &key, const std::string &message) const
  {
    throw Error(key.empty() ? node->pointer : node->pointer + "/" + key, message);
  }


  const Registry &
  Parameters::registry() const
  {
    return *node->document->registry;
  }
} // namespace feib
