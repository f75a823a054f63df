"""Pages of the verification book: contact of elastic bodies, and bodies that are not pressed by an indenter."""

from result_page import Page

JOHNSON = "K. L. Johnson (1985): Contact Mechanics. Cambridge University Press. doi:10.1017/CBO9781139171731"
SNEDDON = ("I. N. Sneddon (1965): The relation between load and penetration in the axisymmetric Boussinesq problem for a punch of arbitrary "
           "profile. Int. J. Eng. Sci. 3, 47-57. doi:10.1016/0020-7225(65)90019-4")
FROM_ANALYTIC = "The value is that of the formula in `scripts/analytic.py`, a formula of textbooks; the source itself was not read."
EXACT = "none, the theory is exact"
SMALL_STRAIN = "exact for small strain; slopes of 1/40 change it by 0.1 %"
HALF_PLANE = ("The block is a half model of 100 and 200 cells along each side with half a contact of 7.5 cells, and of 300 cells with 12, pressed, "
              "held and damped. In plane strain a depth has no value of its own, so that all is compared for the load that was measured.")
SNEDDON_KNOWN = ("Sneddon's integral for the profile is evaluated by the midpoint rule (`sneddon` in `tests/cases/tips.py`); the paper itself was "
                 "not read. Loads and radii are those of a half space, extrapolated from blocks of 16 and 32 contact radii; the picture has the "
                 "larger block by itself, which is a little stiffer.")
SNEDDON_OURS = "1 % of the load, 1.5 % of the radius, by the cells"

CONTACT = [
    Page("hertz_ball", "Hertz: a ball on a half space",
         "A rigid ball is pressed on an elastic block, in axisymmetry and, as a quarter, in space, on three levels. Its radius is 120 of the finest "
         "cells, that of the contact 8. The pressures of single columns are compared with half an ellipse.",
         ("H. Hertz (1882): Über die Berührung fester elastischer Körper. J. reine angew. Math. 92, 156-171. doi:10.1515/crll.1882.92.156", JOHNSON),
         "Width and pressures follow from the load that was measured, by the formulas of textbooks; the sources themselves were not read.",
         (("indentation.sphere_on_levels", ""),), "2 % of the width, 4 % of the peak, by the cells", EXACT, cells="8", plot="Pressures of columns",
         headline="half width|largest p_i", files=("sphere_axisymmetric",), sketch="gallery/sphere_axisymmetric_case.png"),
    Page("hertz_cylinder", "Hertz: a cylinder on a half plane",
         "A rigid cylinder of 60 half widths in radius is pressed on a large elastic block in plane strain. " + HALF_PLANE, (JOHNSON,), FROM_ANALYTIC,
         (("half_plane.half_plane", "cylinder"),), "1.5 % of the load for a width of 7.5 cells, 1 % of stresses", EXACT, cells="7.5 to 12",
         plot="Cylinder", sketch="sketches/ball.png"),
    Page("blunt_wedge", "A blunt wedge on a half plane",
         "A rigid wedge whose faces lean by 1 degree is pressed on a large elastic block in plane strain. The pressure has no limit under its edge. "
         + HALF_PLANE, (JOHNSON,), FROM_ANALYTIC, (("half_plane.half_plane", "wedge"),), "1.5 % of the load for a width of 7.5 cells, 1 % of stresses",
         EXACT, cells="7.5 to 12", plot="Wedge", sketch="sketches/wedge.png"),
    Page("flat_punch_plane", "A flat punch on a half plane, with its singular edge",
         "A rigid flat punch is pressed on a large elastic block in plane strain. The exact pressure has no limit at its edge. " + HALF_PLANE,
         (JOHNSON,), FROM_ANALYTIC, (("half_plane.half_plane", "flat punch"),), "0.4 % of stresses, by the cells", EXACT, cells="7 to 12",
         plot="Flat punch",
         sketch="sketches/punch.png",
         notes="A grid cannot show an edge sharper than a cell: the punch acts as if a quarter of a cell wider, which the widths here count in."),
    Page("sneddon_cone", "Sneddon: a cone",
         "A rigid blunt cone of 88.5 degrees is pressed on an elastic body in axisymmetry, to a contact of eight cells.", (SNEDDON,), SNEDDON_KNOWN,
         (("tips.sneddon", "cone:"),), SNEDDON_OURS, SMALL_STRAIN, plot="cone", sketch="sketches/cone.png"),
    Page("sneddon_paraboloid", "Sneddon: a paraboloid",
         "A rigid paraboloid, given as a profile in a file, is pressed on an elastic body in axisymmetry, to a contact of eight cells. The result is "
         "Hertz's.", (SNEDDON,), SNEDDON_KNOWN, (("tips.sneddon", "paraboloid"),), SNEDDON_OURS, SMALL_STRAIN, plot="paraboloid",
         sketch="sketches/paraboloid.png"),
    Page("sneddon_punch", "Sneddon: a round flat punch",
         "A rigid round flat punch of eight cells is pressed on an elastic body in axisymmetry: its load is 2 E* a h.", (SNEDDON,), SNEDDON_KNOWN,
         (("tips.sneddon", "flat punch"),), SNEDDON_OURS, SMALL_STRAIN, plot="flat punch", files=("punch_axisymmetric",),
         sketch="gallery/punch_axisymmetric_case.png"),
    Page("sneddon_power", "Sneddon: a tip of the fourth power",
         "A rigid tip whose height grows as the fourth power of the radius, given as a profile in a file, is pressed on an elastic body in "
         "axisymmetry, to a contact of eight cells.", (SNEDDON,), SNEDDON_KNOWN, (("tips.sneddon", "fourth power"),), SNEDDON_OURS, SMALL_STRAIN,
         plot="fourth power", sketch="sketches/fourth_power.png"),
    Page("sneddon_tips", "Sneddon: tips of laboratories",
         "Four tips as instruments have them are pressed on an elastic body in axisymmetry, to a contact of eight cells: an area function, a flat punch "
         "with a round edge, a ball, and a cone that ends in a ball.", (SNEDDON,), SNEDDON_KNOWN,
         (("tips.sneddon", "(area function|rounded punch|ball|conosphere)"),), SNEDDON_OURS, SMALL_STRAIN, plot="conosphere",
         sketch="sketches/round_edge.png"),
    Page("pyramids", "Pyramids on a half space",
         "Pyramids with three and four faces are pressed on elastic blocks in space, on three levels: shallow ones, whose faces lean by 1 in 10, and "
         "Vickers and Berkovich tips, 3.5 of the finest cells deep.",
         ("Shallow pyramids: boundary elements of the linear half space, computed for this program.",
          "Vickers and Berkovich: published finite elements, as typed into `verify_pyramids` of `tests/cases/indentation.py`."),
         "What the block's size adds to the load is taken off by the load and depth of a ball on the same block.", (("indentation.pyramids", ""),),
         "3 to 5 %, by 3.5 cells of depth", "about 1 %", headline="half space|of the cone|over that", sketch="sketches/pyramid.png"),
    Page("boussinesq", "Boussinesq: a pressure on a circle",
         "A pressure acts on a circle of eight cells in radius on an elastic half space, in axisymmetry: the stress on the axis, and how far the middle "
         "sinks, extrapolated from blocks of 16 and 32 radii.",
         ("J. Boussinesq (1885): Application des potentiels à l'étude de l'équilibre et du mouvement des solides élastiques. Gauthier-Villars, Paris.",
          JOHNSON),
         "The values are those of the closed form for a circle, the integral of Boussinesq's point load; the sources themselves were not read.",
         (("layered.boussinesq", ""),), "1.4 % of stresses at a border of levels, 0.6 % elsewhere; 0.1 % of the displacement",
         EXACT, cells="8", plot="Stress on the axis",
         sketch="sketches/load.png",
         notes="A border of levels lies 4 radii below the load: the stress of points at it is 1.4 % low."),
    Page("flamant", "Flamant: a line load on a half plane",
         "A pressure acts on a strip of 16 cells on a large elastic block in plane strain: the stress on the axis below it, and the stress toward the "
         "load far from it, in three directions.",
         ("A. Flamant (1892): Sur la répartition des pressions dans un solide rectangulaire chargé transversalement. C. R. Acad. Sci. Paris 114, 1465-1468.",
          JOHNSON),
         "Near the strip the values are Flamant's solution, integrated over it; the sources themselves were not read.", (("layered.flamant", ""),),
         "1.4 % at borders of levels, 0.6 % elsewhere", EXACT, cells="8", plot="Stress on the axis",
         sketch="sketches/load.png",
         notes="Borders of levels lie 4 and 8 half widths below the load: the stress of points at them is 1.3 % low, 0.1 % at 3 and 6 half widths."),
    Page("spence", "Spence and Mossakovskii: a flat punch that sticks",
         "A round flat punch that sticks to the surface is pressed on an elastic block in axisymmetry; its load over that of a smooth punch is known "
         "for a half space, (1 - ν) ln(3 - 4 ν)/(1 - 2 ν). Eight cells are under the punch, blocks of 8 and 12 of its radii say what a half space has.",
         ("V. I. Mossakovskii (1954), and D. A. Spence (1968): Self similar solutions to adhesive contact problems with incremental loading. "
          "Proc. R. Soc. Lond. A 305, 55-80. doi:10.1098/rspa.1968.0105",),
         "The ratio is that of the formula in `tests/cases/friction.py`; the papers themselves were not read.", (("friction.sticking_punch", ""),),
         "0.1 %, by the block and the cells", EXACT, cells="8", sketch="sketches/punch.png"),
    Page("cattaneo_mindlin", "Cattaneo and Mindlin: a cylinder that is pushed sideways",
         "A cylinder is pressed on a nearly incompressible half plane under a constant load and pushed sideways: the contact slips from its rim "
         "inwards, until all of it slips. The heat of friction is known over the tangential force.",
         ("C. Cattaneo (1938): Sul contatto di due corpi elastici. Rend. Accad. Naz. Lincei 27, 342-348, 434-436, 474-478.",
          "R. D. Mindlin (1949): Compliance of elastic bodies in contact. J. Appl. Mech. 16, 259-268.", JOHNSON),
         "The heat is derived from the sticking middle that both have, in `tests/cases/partial_slip.py`, and was compared with a numerical integral; "
         "the papers themselves were not read.", (("partial_slip.cattaneo_mindlin", ""),), "1 to 2 % from half of the force on, by the cells",
         "1 %: a Poisson's ratio of 0.49 for 0.5", plot="Heat", headline="heat at", cells="8", sketch="sketches/sideways.png"),
    Page("barnett_lothe", "Barnett and Lothe: crystals of silicon and copper",
         "A flat punch is pressed on three planes of silicon and two of copper, in space: a quarter model, on (111) a half. Blocks of 16 and 32 radii "
         "give the modulus P/(2 a h) of a half space.",
         ("D. M. Barnett, J. Lothe (1975): Line force loadings on anisotropic half-spaces and wedges. Phys. Norv. 8, 13-22.",
          "J. J. Vlassak, W. D. Nix (1994): Measuring the elastic properties of anisotropic materials by means of indentation experiments. "
          "J. Mech. Phys. Solids 42, 1223-1245. doi:10.1016/0022-5096(94)90033-7"),
         "Barnett and Lothe's integral is evaluated by `indentation_modulus` of `scripts/analytic.py`; the papers themselves were not read.",
         (("crystals.silicon", ""),), "1 %, that of an isotropic block too; 0.1 % of ratios to it", "none where the contact is round",
         cells="8", headline="half space|over", files=("silicon_001",), sketch="gallery/silicon_001_case.png",
         notes="The compliance that a block adds goes as the inverse of its size: on 16 and 32 radii silicon has moduli 4 and 1 % too large, by up to 1.2 "
         "and 0.6 % of them another part than the isotropic block, as far from the tip other constants count; a half space follows from the two. What "
         "is left, the same 1 % of all crystals, is the grid's at the edge of the punch."),
    Page("zinc", "Zinc on its basal plane",
         "A flat punch is pressed on the basal plane of zinc in axisymmetry, on three levels, with a block of 128 radii. Its modulus P/(2 a h) has a "
         "closed form.",
         ("A. Delafargue, F.-J. Ulm (2004): Explicit approximations of the indentation modulus of elastically orthotropic solids for conical indenters. "
          "Int. J. Solids Struct. 41, 7351-7360. doi:10.1016/j.ijsolstr.2004.06.019",),
         "The modulus is that of the formula in `scripts/analytic.py`; the paper itself was not read.", (("crystals.zinc", ""),),
         "0.5 %, that of an isotropic block too", EXACT, cells="8", sketch="sketches/punch.png"),
    Page("film_under_pressure", "Burmister: a pressure on a film on a substrate",
         "A pressure acts on a circle of eight cells in radius on an elastic film that is bonded to a substrate four times as stiff, in axisymmetry: how "
         "far the middle sinks, for films of half that radius, of the radius and of four radii.",
         ("D. M. Burmister (1945): The general theory of stresses and displacements in layered systems. J. Appl. Phys. 16, 89-94. doi:10.1063/1.1707558",),
         "The compliance of film and substrate to each wave is solved for by a matrix exponential over the film's depth, and added up by Hankel's integral, "
         "in `tests/cases/layered.py`; the paper itself was not read.", (("layered.film_under_pressure", ""),),
         "1 %, by the block and the cells", EXACT, cells="8", sketch="sketches/film_load.png"),
    Page("film_interface", "A film whose interface cuts cells",
         "A ball is pressed on an elastic film of four cells on a substrate four times as stiff. The film's thickness changes by half a cell, so that "
         "the interface lies on lines of the grid or between them.",
         ("Interpolation between films that end on lines of the grid, by the program itself.",),
         "This is a study of convergence: a cell that the interface cuts shares one strain, as layers side by side do, and is too stiff by an error "
         "of the first order.", (("film.interface", ""),), "3 % with cells of a fourth of the film, 0.5 % with a sixteenth", "0.1 % of the cubic", plot="Error",
         sketch="sketches/film.png"),
]

FREE = [
    Page("lame", "Lamé: a ring under a pressure within",
         "A thick elastic ring, twice as wide outside as inside, is pressed apart by a pressure within, in axisymmetry and held along its axis.",
         ("G. Lamé (1852): Leçons sur la théorie mathématique de l'élasticité des corps solides. Bachelier, Paris.",),
         "The values are those of the closed form of textbooks; the source itself was not read.", (("axisymmetry.lame", ""),),
         "0.02 % of the displacement, 3 % of stresses, of the first order in the cells", EXACT, cells="16 and 32 across", plot="Stresses",
         headline="stress: rms", sketch="sketches/ring_pressure.png"),
    Page("squeezed_ring", "A ring between two plates",
         "A thin elastic ring, whose wall is a tenth of its radius, lies between two plates that come closer, in plane strain.",
         ("S. Timoshenko (1956): Strength of materials, part II. Van Nostrand.",),
         "The energy of a curved beam, with tension and shear, is added up around the ring in `tests/cases/bending.py`; the book was not read for this page.",
         (("bending.squeezed_ring", ""),), "1 %, by the cells", "0.5 %: the flattening at the plates", cells="4 and 8 across", plot="Load at rest",
         sketch="sketches/squeezed_ring.png",
         notes="The ring becomes softer as it flattens: the rows without a goal have that."),
    Page("elastica", "The elastica: a beam under its weight",
         "A cantilever twelve times as long as thick falls under its weight and comes to rest, damped. Deflections go up to half of the length.",
         ("L. Euler (1744): Methodus inveniendi lineas curvas maximi minimive proprietate gaudentes. Bousquet, Lausanne.",),
         "The equation of an inextensible beam without shear is solved by collocation in `tests/cases/bending.py`.", (("bending.elastica", ""),),
         "1 %, by 4 and 8 cells in the thickness", "0.5 %: shear, which the beam has and the elastica has not", cells="4 and 8 across",
         plot="Deflection", sketch="sketches/beam.png"),
    Page("static_bar", "A bar at rest under a traction",
         "A bar between rollers is pulled and pressed by a traction of up to 5 % of Young's modulus and comes to rest. At any strain Cauchy's stress "
         "is then the traction on the present face, and the stretch follows from the law.",
         ("Equilibrium.",), "The stretch is that of the law by hand, in `tests/cases/bar.py`.", (("bar.static_stress", ""),),
         "0.9 % of the stress at 5 % strain, by the cells", EXACT, cells="4 across the bar",
         sketch="sketches/bar.png",
         notes="The table has the largest error by the coefficients a,b of `-short_wave_viscosity` and the time of the hold, in transits of waves: it does "
         "not grow with time, with or without the viscosity."),
    Page("bar_waves", "d'Alembert: waves in a bar",
         "The end of a bar between rollers is pulled by a traction that rises over half of a transit of waves, to a strain of 1e-5. The waves run "
         "there and back twice.", ("J. d'Alembert (1747): the wave equation.",), FROM_ANALYTIC, (("bar.waves", ""),),
         "0.1 % of the displacement, 1.6 % of the stress, of the first order in the cells", EXACT, cells="4 across, 49 along", plot="Displacement",
         headline="error|of the peak|traction", sketch="sketches/bar.png"),
]
