"""Load sharing of one disc on a rigid crank: the published iteration and the true moment balance."""

from cycloid_profile.contact.disc.classical import Classical as Classical
from cycloid_profile.contact.disc.equilibrium import Equilibrium as Equilibrium
