// SPDX-License-Identifier: LGPL-2.1-or-later
#ifndef feib_structure_model_elastic_structure_h
#define feib_structure_model_elastic_structure_h

#include <feib/constitutive_law.h>
#include <feib/structure_model.h>
#include <feib/structure_model/face_loads.h>
#include <feib/structure_model/moments.h>
#include <feib/structure_model/structure_forces.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace feib
{
  /// An elastic structure of dimension m = dim or dim-1 on P1 simplices: what the components
  /// `hyperelastic` and `membrane` share. P is constant on an element, so integration by parts is
  /// exact and the load lives on the faces (FaceLoads).
  template <int structure_dim, int dim>
  class ElasticStructure : public StructureModel<dim>
  {
  public:
    static constexpr unsigned int m = structure_dim;

    using Law       = ConstitutiveLaw<structure_dim, dim>;
    using Matrix    = typename Law::Matrix;
    using Mesh      = LagrangianMesh<dim>;
    using Stiffness = typename StructureModel<dim>::Stiffness;
    using Forces    = typename StructureForces<dim>::List;

    /// The component makes the law, from the slot "law" of the same block. Throws Error where
    /// elements are inverted that must not be, and where a body is none.
    ElasticStructure(const Parameters &parameters, std::unique_ptr<Law> constitutive_law);

    const std::string &name() const override;

    const Mesh &mesh() const override;

    void archive(Archive &archive) override;

    void set_forces(Forces forces) override;

    std::vector<std::string> force_names() const override;

    std::vector<double> force_energies(const Positions<dim> &X) const override;

    std::vector<NodalField<dim>> force_loads(const Positions<dim> &X,
                                             const Positions<dim> &geometry,
                                             const NodalField<dim> &U) const override;

    void set_moment(double time, double elapsed) override;

    void update_state(const Positions<dim> &X) override;

    std::vector<std::pair<std::string, std::vector<double>>> state() const override;

    /// The functions of X throw RunFailure on all ranks where an element is inverted that must not
    /// be, and where the law fails.
    double energy(const Positions<dim> &X) const override;

    const LagrangianPoints &load_points() const override;

    void load(const Positions<dim> &X, NodalField<dim> &load) const override;

    void load_derivative(const Positions<dim> &X,
                         const NodalField<dim> &dX,
                         NodalField<dim> &dload) const override;

    MatrixEntries tangent(const Positions<dim> &X) const override;

    bool viscous() const override;

    void viscous_load(const Positions<dim> &X,
                      const NodalField<dim> &U,
                      NodalField<dim> &load) const override;

    MatrixEntries viscous_tangent(const Positions<dim> &X) const override;

    bool external() const override;

    void external_load(const Positions<dim> &X, NodalField<dim> &load) const override;

    bool linear() const override;

    bool conservative() const override;

    const std::vector<double> &excess_mass() const override;

    Stiffness stiffness(const Positions<dim> &X) const override;

    double measure(const Positions<dim> &X) const override;

    dealii::Point<dim> centroid(const Positions<dim> &X) const override;

    dealii::SymmetricTensor<2, dim> second_moments(const Positions<dim> &X) const override;

    std::vector<dealii::SymmetricTensor<2, dim>>
    cauchy_stress(const Positions<dim> &X) const override;

    std::vector<double> energy_density(const Positions<dim> &X) const override;

  private:
    /// An element is inverted, or its determinant is not a number: the worst one.
    struct Inverted
    {
      double determinant;
      unsigned int element;
    };

    /// Throws Error where elements are inverted that must not be, and where a body is none.
    void check_initial_positions(const Parameters &parameters) const;

    /// Gives the law its points. What it throws on one rank is thrown on all.
    void set_points();

    /// The gradient of a nodal field on the elements of this rank.
    template <typename Field>
    std::vector<Matrix> gradients(const Field &field) const;

    /// The element of smallest det F when that is not positive and the law needs it. Collective.
    std::unique_ptr<Inverted> find_inverted(const std::vector<Matrix> &F) const;

    /// The deformation gradients at X. Throws RunFailure on all ranks where an element is inverted.
    std::vector<Matrix> deformation_gradients(const Positions<dim> &X) const;

    /// Calls a function of the law that fills @p values, one for each element of this rank. What it
    /// throws on any rank, or a value that is not finite, is a RunFailure on all. Collective.
    template <typename Value, typename Function>
    void evaluate(const char *what, const Function &function, std::vector<Value> &values) const;

    /// W of this rank's elements. Collective.
    std::vector<double> local_energy_density(const Positions<dim> &X) const;

    using Columns = typename FaceLoads<structure_dim, dim>::Columns;

    /// What a linear function of this rank's matrices, (dF, dP), gives for each unit dF.
    template <typename Function>
    Columns columns(const char *what, const Function &function) const;

    /// d2W/dF2 of this rank's elements. Collective.
    Columns tangent_columns(const std::vector<Matrix> &F) const;

    /// Values of this rank's elements as values of all. Collective.
    std::vector<double> all_elements(const std::vector<double> &local) const;

    /// The beginning of a sentence.
    std::string law_fails(const char *what) const;

    /// Hands the law the moment.
    void tell_moment();

    /// Forgets what depends on the moment, where the law or a force does.
    void moment_has_changed();

    const Moments<dim> &measure_moments(const Positions<dim> &X) const;

    std::string structure_name;
    Mesh reference_mesh;
    unsigned int first, last; // the elements of this rank
    std::string law_name;
    std::unique_ptr<Law> law;
    std::vector<std::string> state_names;
    typename Law::Moment moment; // of this rank's elements
    FaceLoads<structure_dim, dim> faces;
    LagrangianPoints points; // the load points
    StructureForces<dim> forces;
    std::vector<double> node_masses; // lumped excess mass; empty: none

    /// A function of positions that is not computed twice for the same ones: schemes, accounts and
    /// step control ask for the same energies, stiffnesses and measures.
    template <typename Value>
    class Remembered
    {
    public:
      template <typename Function>
      const Value &
      at(const Positions<dim> &X, const Function &function)
      {
        if (positions != X)
          {
            value     = function();
            positions = X;
          }
        return value;
      }

      void
      forget()
      {
        positions = {};
      }

    private:
      Positions<dim> positions;
      Value value;
    };

    mutable Remembered<double> last_energy;
    mutable Remembered<Stiffness> last_stiffness;
    mutable Remembered<Moments<dim>> last_moments;
  };
} // namespace feib

#endif
