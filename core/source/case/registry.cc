// SPDX-License-Identifier: LGPL-2.1-or-later
#include "json.h"

#include <feib/registry.h>
#include <feib/schema.h>

#include <algorithm>

namespace feib
{
  namespace
  {
    /// What a factory throws that is no sentence for a user, with the component's name.
    struct ComponentFailure : std::runtime_error
    {
      using std::runtime_error::runtime_error;
    };
  } // namespace


  struct Registry::Implementation
  {
    struct Component
    {
      Entry entry;
      std::map<std::string, Factory> factories;
    };

    std::map<std::pair<std::string, std::string>, Component> components;
    std::string plugin, origin; // of the transaction

    std::vector<std::string>
    names(const std::string &kind) const
    {
      std::vector<std::string> result;
      for (const auto &[key, component] : components)
        if (key.first == kind)
          result.push_back(key.second);
      return result;
    }

    const Component &
    find(const std::string &kind, const std::string &name, const std::string &pointer) const
    {
      const auto place = components.find({kind, name});
      if (place == components.end())
        throw Error(pointer,
                    "no plugin provides the " + kind + " \"" + name + "\"; available are " +
                      quoted_list(names(kind)));
      return place->second;
    }
  };


  Registry::Registry()
    : implementation(std::make_unique<Implementation>())
  {}


  Registry::~Registry() = default;


  Registry::Registry(Registry &&) = default;


  Registry &Registry::operator=(Registry &&) = default;


  void
  Registry::add(const std::string &kind,
                const std::string &name,
                const std::string &schema,
                std::vector<std::pair<std::string, Factory>> factories)
  {
    if (name.empty() || !std::all_of(name.begin(), name.end(), [](const unsigned char c) {
          return std::isalnum(c) || c == '_';
        }))
      throw Error("the name \"" + name + "\" of a component (" + kind +
                  ") may only hold letters, digits and underscores");
    if (const auto place = implementation->components.find({kind, name});
        place != implementation->components.end())
      {
        const std::string &origin = place->second.entry.origin;
        throw Error("the " + kind + " \"" + name + "\" exists already" +
                    (origin.empty() ? "" : ", from " + origin));
      }
    constexpr std::size_t largest = 1 << 20; // bytes; they are read whenever the program starts
    if (schema.size() > largest)
      throw Error("the schema of the " + kind + " \"" + name + "\" has " +
                  std::to_string(schema.size()) + " bytes; at most " + std::to_string(largest) +
                  " are allowed");
    Issues issues = Schema::component_issues(schema);
    for (Issue &issue : issues)
      issue = {"",
               "the schema of the " + kind + " \"" + name + "\" breaks the rules at " +
                 (issue.pointer.empty() ? "its root" : issue.pointer) + ": " + issue.message};
    if (!issues.empty())
      throw Error(issues);
    implementation->components[{kind, name}] = {
      {kind, name, schema, implementation->plugin, implementation->origin},
      std::map<std::string, Factory>(factories.begin(), factories.end())};
  }


  bool
  Registry::offers(const std::string &kind,
                   const std::string &signature,
                   const std::string &name) const
  {
    for (const Entry &entry : entries())
      if (entry.kind == kind && entry.name == name)
        return implementation->find(kind, name, "").factories.count(signature) > 0;
    return false;
  }

  void *
  Registry::create(const std::string &kind,
                   const std::string &signature,
                   const std::string &name,
                   const Parameters &parameters) const
  {
    const auto &component = implementation->find(kind, name, parameters.pointer());
    const auto factory    = component.factories.find(signature);
    if (factory == component.factories.end())
      throw Error(parameters.pointer(),
                  "the " + kind + " \"" + name + "\" is not offered for " + signature);
    const auto failed = [&](const std::string &what) {
      const auto &entry = component.entry;
      return ComponentFailure(
        parameters.pointer() + ": the " + kind + " \"" + name + "\" cannot be made: " + what +
        (entry.origin.empty() ? "" : "; it is from the plugin " + entry.origin));
    };
    try
      {
        return factory->second(parameters);
      }
    catch (const Error &)
      {
        throw;
      }
    catch (const RunFailure &)
      {
        throw;
      }
    catch (const ComponentFailure &)
      {
        throw;
      }
    catch (const std::bad_alloc &)
      {
        throw;
      }
    catch (const std::exception &failure)
      {
        throw failed(failure.what());
      }
    catch (...)
      {
        throw failed("it throws something that is no std::exception");
      }
  }


  Parameters
  Registry::parse(const std::string &kind,
                  const std::string &name,
                  const std::string &json,
                  const MPI_Comm communicator) const
  {
    const Schema schema = Schema::expand(implementation->find(kind, name, "").entry.schema, this);
    std::string filled  = json;
    Issues issues       = schema.explain(filled);
    if (issues.empty())
      {
        filled = schema.with_defaults(filled);
        issues = schema.explain(filled); // a default may name a component that is not there
      }
    if (!issues.empty())
      throw Error(issues);
    const auto document = std::make_shared<Document>(
      Document{Json::parse(filled), this, mathematical_constants(), {}, ".", communicator});
    return Parameters(
      std::make_shared<Parameters::Node>(Parameters::Node{document, &document->root, ""}));
  }


  Registry::Entry
  Registry::find(const std::string &name) const
  {
    std::vector<Entry> found;
    std::vector<std::string> names;
    std::string all;
    for (const Entry &entry : entries())
      {
        const std::string full = entry.kind + "/" + entry.name;
        names.push_back(entry.name);
        all += "\n  " + full;
        if (entry.name == name || full == name)
          found.push_back(entry);
      }
    if (found.size() == 1)
      return found[0];
    if (names.empty())
      throw Error("there is no component \"" + name + "\": no plugin provides any");
    const std::string guess = nearest(name, names);
    throw Error((found.empty() ? "there is no component \"" : "there are several components \"") +
                name + "\"" +
                (guess.empty() || !found.empty() ? "" : "; did you mean \"" + guess + "\"?") +
                "; the components are" + all);
  }


  std::vector<Registry::Entry>
  Registry::entries() const
  {
    std::vector<Entry> result;
    for (const auto &[key, component] : implementation->components)
      result.push_back(component.entry);
    return result;
  }


  void
  Registry::transaction(const std::string &plugin,
                        const std::string &origin,
                        const std::function<void(Registry &)> &fill)
  {
    const auto before      = std::make_unique<Implementation>(*implementation);
    implementation->plugin = plugin;
    implementation->origin = origin;
    try
      {
        fill(*this);
      }
    catch (...)
      {
        *implementation = *before;
        throw;
      }
    implementation->plugin = before->plugin;
    implementation->origin = before->origin;
  }
} // namespace feib
