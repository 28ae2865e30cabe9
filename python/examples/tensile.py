"""A block is pulled at one end: the tensile test of section 5.2, coarsely."""

import rsph


def tensile(spacing: float = 0.25, until: float = 1.0) -> rsph.Simulation:
    """Runs the test and returns the simulation at its end."""
    bottom = rsph.regions.plane(axis="z", at=0.0, side="below")
    top = rsph.regions.plane(axis="z", at=1.0, side="above")
    sim = rsph.Simulation(
        shape=rsph.shapes.Box(size=(1.0, 1.0, 1.0)),
        spacing=spacing,
        material=rsph.materials.KelvinVoigt(
            density=1.0, young_modulus=100.0, poisson_ratio=0.3, relaxation_time=0.2
        ),
        boundaries=[rsph.boundaries.Clamp(region=bottom)],
        loads=[rsph.loads.Traction(region=top, traction=(0.0, 0.0, 1.0))],
        probes=[rsph.Probe(name="extension", quantity="displacement.z", region=top)],
        units="normalised",
    )
    sim.run(until=until)
    return sim


if __name__ == "__main__":
    sim = tensile()
    print(sim)
    print(f"extension: {sim.probes()['extension']:.5f}")
    print(f"largest stress: {sim.snapshot().von_mises.max():.3f}")
