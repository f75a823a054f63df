"""The cases of the gallery, one row each: scripts/gallery.py draws their pictures, and pages.py writes their pages."""

from typing import NamedTuple


class Case(NamedTuple):
    """A case of options/NAME.opts, what its page says, and which pictures of its result it has."""
    name: str
    title: str
    shows: str  # the physics
    look: str  # what to look for in the pictures
    pictures: tuple  # (name as in scripts/plot.py, window: None, "near" or (xmin, xmax, ymin, ymax) in m)


CASES = [
    Case("tension", "A bar under tension",
         "One end of a silicon bar is held and the other one is pulled, with a stress that rises to 8 GPa within half the time; the "
         "bar grows by 6 %. This is Fig. 9 of the paper.",
         "The stress along x is smooth, though points cross cells. With `-shape_function linear`, the original material point method, "
         "the same bar tears.",
         (("stress_xx", None),)),
    Case("pressure", "A pressure on a part of a side",
         "A pressure of up to 60 GPa acts on the middle of a silicon block, of which the right half is simulated. The pressure "
         "follows the faces of the points as they move (Figs. 10 and 11 of the paper).",
         "The stress under the load is that of the pressure, and the surface next to the load sinks without a step.",
         (("stress_yy", None),)),
    Case("wedge_3level", "A wedge on three levels",
         "A wedge is pressed 450 nm into aluminium, on three nested levels of the grid: only the contact has cells of 125 nm. This is "
         "the case that `make run` runs (Figs. 12 to 16 of the paper).",
         "The stress is continuous where it crosses the box of the finest level. The load grows in proportion to the depth, as it "
         "must under a wedge, without stairs.",
         (("stress_yy", "near"), ("load_depth", None))),
    Case("sphere_axisymmetric", "Hertz's contact: a sphere on an elastic block",
         "A rigid sphere with a radius of 100 µm is pressed 400 nm into aluminium, in axisymmetry: x is the radius.",
         "The pressure over the radius is half an ellipse, as Hertz found, with a largest value near 1.5 times its mean, although the "
         "radius of the contact is only 6.5 cells.",
         (("contact_pressure", None),)),
    Case("punch_axisymmetric", "A round flat punch",
         "A flat punch with a radius of 8 µm is pressed 50 nm into an elastic block. The radius of the contact is given, so that the "
         "stiffness is 2 E* a, and somewhat more because the block is finite.",
         "The stress is largest under the edge of the punch, where the exact solution has no limit, and small below its middle.",
         (("von_mises_stress", (-24e-6, 24e-6, 36e-6, 67e-6)),)),
    Case("cone_metal", "The hardness of a metal under a cone",
         "A cone with the section of a Berkovich tip is pressed 200 nm into a metal with a yield stress of 1 GPa, on three levels with "
         "a ratio of 4. Finite elements give a load of 52.2 GPa times the square of the depth (Lu, Dao and others, 2020).",
         "The plastic zone keeps its shape while it grows, so that the load is a parabola. It ends at 2.13 mN, where finite elements "
         "give 2.09 mN.",
         (("equivalent_plastic_strain", (-1.4e-6, 1.4e-6, 24.4e-6, 26e-6)), ("load_depth", None))),
    Case("film", "A soft film on a stiff substrate",
         "A cone is pressed into a metal film of 1 µm on silicon, in four cycles to 70 % of the film's thickness. The test is slow: "
         "with `-quasi_static` the program chooses speeds, holds and damping.",
         "The plastic zone spreads along the interface, because the substrate does not yield. Each unloading is steep: most of the "
         "depth stays.",
         (("equivalent_plastic_strain", (-4.5e-6, 4.5e-6, 13.5e-6, 16.6e-6)), ("load_depth", None))),
    Case("film_stress", "A film under compression",
         "A metal film of 1.2 µm on silicon has a compressive stress of 200 MPa, half its yield stress, before a cone is pressed 400 nm "
         "into it: `-film_initial_stress -200e6,0`. The side of the block bears it.",
         "Far from the tip the film keeps its stress, and below the tip it is far larger. More metal piles up than without a stress, so "
         "that the contact is larger and so is the load; load over contact area is the same.",
         (("stress_xx", (-4.5e-6, 4.5e-6, 13.5e-6, 16.7e-6)), ("load_depth", None))),
    Case("silicon_001", "A ball on a crystal",
         "A ball with a radius of 10 µm is pressed 100 nm into silicon on its (001) plane; a quarter is simulated, on three levels. Silicon "
         "is stiffer along [111] than along [100]: its indentation modulus is 164.8 GPa on (001) and 175.3 GPa on (111).",
         "At its largest depth the ball carries four times 5.7 mN. With 4/3 M √R h³ᐟ² a half space would carry four times 5.5 mN; the "
         "block has only 12 times the contact's radius.",
         (("stress_zz", (0, 3.2e-6, 9.6e-6, 13.2e-6)),)),
    Case("fused_silica_tip", "A laboratory's tip in fused silica",
         "A worn Berkovich tip, given by its area function, goes 250 nm into fused silica on a frame of 1 N/µm, with five small unloadings on "
         "the way (`-indenter_unloadings 5`); then it goes back. Lengths, forces and the material are written as people say them: `250nm`, "
         "`1N/um`, `-silica_preset fused_silica`.",
         "Each small unloading has its own stiffness, so that one test gives hardness and modulus over the depth: `scripts/indentation.py "
         "output/fused_silica_tip --csm`. The hardness is 8.8 GPa at 50 nm, where the tip is round, and 9.2 to 9.3 GPa from "
         "100 nm on; the modulus, 78 GPa for 72 that were given, has some 5 % of the block's size in it.",
         (("load_depth", None), ("von_mises_stress", "near"))),
    Case("indium_hold", "A hold on indium",
         "A cone takes 1 mN within 10 s, holds it for ten minutes and lets go. Indium creeps by a power of the stress, so that what counts "
         "is the time of the test, `-test_times`, which the simulation takes as fast as the creeping tip allows.",
         "In the hold the depth grows by half, along a straight line over the logarithm of time. The unloading has a nose: the stiffness "
         "at its start seems twice as large as it is. With the creep at the end of the hold taken off, the modulus falls from 24.7 GPa to 12.7 GPa, "
         "which was given.",
         (("test", None), ("equivalent_plastic_strain", (-12e-6, 12e-6, 82e-6, 98e-6)))),
    Case("pmma_hold", "A ball on a polymer",
         "A ball is pressed with 2 mN on a glassy polymer, a generalized Maxwell solid of three terms, held for 100 s and let go; then the "
         "polymer is left alone for 100 s.",
         "Under the load the depth grows by 22 %. Afterwards the imprint of 69 nm comes back to 15 nm, as what has relaxed finds its way.",
         (("test", None), ("load_depth", None))),
    Case("rod_impact", "The heat of an impact",
         "A copper rod meets a rigid wall at 150 m/s. Its flow stress follows Johnson and Cook: it rises with strain and with the "
         "rate of strain and falls with temperature, and plastic work heats each point.",
         "The rod shortens from 25.4 mm to 19.8 mm and its foot spreads. The foot is 110 K warmer than at the start.",
         (("temperature", None),)),
    Case("taylor_bar", "Taylor's test",
         "A copper rod of 32.4 mm meets a rigid wall at 227 m/s, a standard test of programs for large plastic strains.",
         "The rod ends with a length of 21.5 mm and a foot of 7.1 mm radius; other programs give 21.3 to 21.5 mm and 6.9 to 7.2 mm.",
         (("equivalent_plastic_strain", None),)),
    Case("berkovich_3d", "A Berkovich tip in three dimensions",
         "A three-sided pyramid is pressed 400 nm into an elastic block, on two levels. The plane y = 0 is a side of symmetry, so "
         "that half of the tip is simulated and the load is half of the whole.",
         "In the plane y = 0 the tip has a face on its right and an edge on its left, and so the stress is not quite symmetric. Half "
         "the contact is less than two cells wide, of which the program warns: this case is quick, not exact.",
         (("von_mises_stress", (-4.8e-6, 4.8e-6, 3.2e-6, 8.6e-6)),)),
    Case("scratch", "A scratch",
         "A ball is pressed on a metal, slides 0.6 µm along x under a constant load, with a coefficient of friction of 0.2, and is "
         "lifted again; half of it is simulated.",
         "The groove stays, with a pile of metal in front of the ball. The force that resists the motion is 0.36 of the load, because "
         "the ball also ploughs.",
         (("plastic_surface", None),)),
]
