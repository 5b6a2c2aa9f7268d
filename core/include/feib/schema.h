// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_schema_h
#define feib_schema_h

#include <feib/issue.h>

#include <memory>
#include <string>
#include <vector>

namespace feib
{
  class Registry;

  /// A JSON Schema (draft 7) of the restricted keyword set of schemas/component.schema.json.
  class Schema
  {
  public:
    /// Throws Error when @p text is not JSON.
    explicit Schema(const std::string &text);
    Schema(Schema &&);
    ~Schema();

    /// One schema for whole cases: the skeleton (schemas/case.schema.json, embedded in the core)
    /// with every slot, {"slot": kind}, replaced by the components of that kind in the registry,
    /// and every
    /// {"fragment": name} by the entry of "fragments". The schemas of the components stand once,
    /// under "definitions", so that a component may hold a slot of its own kind.
    static Schema compose(const Registry &registry);

    /// The rules for the schemas of components (schemas/component.schema.json, embedded in the
    /// core).
    static const Schema &component_rules();

    /// All that is wrong with the schema of a component: the rules, and what they cannot say.
    static Issues component_issues(const std::string &schema);

    /// Whether valijson, the judge, accepts the document.
    bool accepts(const std::string &document) const;

    /// All that is wrong with the document, in plain words; empty exactly when accepts() is true.
    Issues explain(const std::string &document) const;

    /// The document with every default of the schema filled in.
    std::string with_defaults(const std::string &document) const;

    /// The text of the schema, indented.
    std::string text() const;

    /// The parameters the schema describes, for people: keys, types, ranges, defaults, meanings.
    std::string describe() const;

    /// The texts of the examples the schema gives.
    std::vector<std::string> examples() const;

  private:
    friend class Registry;
    struct Implementation;

    explicit Schema(std::unique_ptr<Implementation> implementation);

    /// A skeleton with its fragments and slots replaced; without a registry a slot takes any name.
    static Schema expand(const std::string &skeleton, const Registry *registry);

    std::unique_ptr<Implementation> implementation;
  };
} // namespace feib

#endif
