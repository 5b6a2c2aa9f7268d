// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_registry_h
#define feib_registry_h

#include <feib/parameters.h>

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace feib
{
  namespace internal
  {
    template <class Interface>
    struct Signature;

    template <template <int> class Interface, int dim>
    struct Signature<Interface<dim>>
    {
      static std::string
      name()
      {
        return "dimension " + std::to_string(dim);
      }
    };

    template <template <int, int> class Interface, int structure_dim, int dim>
    struct Signature<Interface<structure_dim, dim>>
    {
      static std::string
      name()
      {
        return "a structure of dimension " + std::to_string(structure_dim) + " in dimension " +
               std::to_string(dim);
      }
    };
  } // namespace internal


  /// The catalogue of all components, a plain object owned by main (or by a test). A component is
  /// known by its kind (the interface's name, e.g. "constitutive_law") and its own name.
  class Registry
  {
  public:
    Registry();
    ~Registry();
    Registry(Registry &&);
    Registry &operator=(Registry &&);

    struct Entry
    {
      std::string kind, name, schema, plugin, origin;
    };

    /// Adds Component<dim> for dim = 2 and 3 under @p name. @p schema is the text of the JSON
    /// Schema of its parameters; see schemas/component.schema.json for what it may hold. Each
    /// component is constructed from Parameters. Throws Error on a name that exists and on a schema
    /// that breaks the rules.
    template <template <int> class Interface, template <int> class Component>
    void add(const std::string &name, const std::string &schema);

    /// The same for interfaces of a structure, for these pairs (structure_dim, dim).
    template <template <int, int> class Interface, template <int, int> class Component>
    void add(const std::string &name,
             const std::string &schema,
             const std::vector<std::pair<int, int>> &pairs = {{1, 2}, {2, 2}, {2, 3}, {3, 3}});

    /// Builds the component @p name of Interface from its block.
    template <class Interface>
    std::unique_ptr<Interface> create(const std::string &name, const Parameters &parameters) const;

    /// The same from a block as text: validated against the component's schema, defaults filled.
    /// For tests and tools. Throws Error with all issues.
    template <class Interface>
    std::unique_ptr<Interface> create(const std::string &name,
                                      const std::string &json = "{}",
                                      MPI_Comm communicator   = MPI_COMM_WORLD) const;

    /// Whether there is a component @p name of Interface, in its dimensions.
    template <class Interface>
    bool
    offers(const std::string &name) const
    {
      return offers(Interface::kind, internal::Signature<Interface>::name(), name);
    }

    /// The component called @p name, or "kind/name" where several kinds have one of that name.
    /// Throws Error, with the nearest name and the list, when there is no such component or not
    /// only one.
    Entry find(const std::string &name) const;

    /// All components, sorted by kind and name.
    std::vector<Entry> entries() const;

    /// Adds what @p fill adds, all or nothing; @p plugin and @p origin (a file) are noted in the
    /// entries.
    void transaction(const std::string &plugin,
                     const std::string &origin,
                     const std::function<void(Registry &)> &fill);

  private:
    using Factory = std::function<void *(const Parameters &)>;

    template <class Interface, class Component>
    static Factory factory();

    void add(const std::string &kind,
             const std::string &name,
             const std::string &schema,
             std::vector<std::pair<std::string, Factory>> factories);

    bool
    offers(const std::string &kind, const std::string &signature, const std::string &name) const;

    void *create(const std::string &kind,
                 const std::string &signature,
                 const std::string &name,
                 const Parameters &parameters) const;

    Parameters parse(const std::string &kind,
                     const std::string &name,
                     const std::string &json,
                     MPI_Comm communicator) const;

    struct Implementation;
    std::unique_ptr<Implementation> implementation;
  };


  template <class Interface, class Component>
  Registry::Factory
  Registry::factory()
  {
    return [](const Parameters &parameters) -> void * {
      std::unique_ptr<Interface> object = std::make_unique<Component>(parameters);
      return object.release();
    };
  }

  template <template <int> class Interface, template <int> class Component>
  void
  Registry::add(const std::string &name, const std::string &schema)
  {
    add(Interface<2>::kind,
        name,
        schema,
        {{internal::Signature<Interface<2>>::name(), factory<Interface<2>, Component<2>>()},
         {internal::Signature<Interface<3>>::name(), factory<Interface<3>, Component<3>>()}});
  }

  template <template <int, int> class Interface, template <int, int> class Component>
  void
  Registry::add(const std::string &name,
                const std::string &schema,
                const std::vector<std::pair<int, int>> &pairs)
  {
    std::vector<std::pair<std::string, Factory>> factories;
    const auto add_pair =
      [&](const std::pair<int, int> &pair, const std::string &signature, const Factory &factory) {
        if (std::find(pairs.begin(), pairs.end(), pair) != pairs.end())
          factories.emplace_back(signature, factory);
      };
    add_pair({1, 2},
             internal::Signature<Interface<1, 2>>::name(),
             factory<Interface<1, 2>, Component<1, 2>>());
    add_pair({2, 2},
             internal::Signature<Interface<2, 2>>::name(),
             factory<Interface<2, 2>, Component<2, 2>>());
    add_pair({2, 3},
             internal::Signature<Interface<2, 3>>::name(),
             factory<Interface<2, 3>, Component<2, 3>>());
    add_pair({3, 3},
             internal::Signature<Interface<3, 3>>::name(),
             factory<Interface<3, 3>, Component<3, 3>>());
    add(Interface<2, 2>::kind, name, schema, std::move(factories));
  }

  template <class Interface>
  std::unique_ptr<Interface>
  Registry::create(const std::string &name, const Parameters &parameters) const
  {
    return std::unique_ptr<Interface>(static_cast<Interface *>(
      create(Interface::kind, internal::Signature<Interface>::name(), name, parameters)));
  }

  template <class Interface>
  std::unique_ptr<Interface>
  Registry::create(const std::string &name,
                   const std::string &json,
                   const MPI_Comm communicator) const
  {
    return create<Interface>(name, parse(Interface::kind, name, json, communicator));
  }

  template <class Interface>
  std::unique_ptr<Interface>
  Parameters::create() const
  {
    const auto [name, block] = choice();
    return registry().template create<Interface>(name, block);
  }
} // namespace feib

#endif
