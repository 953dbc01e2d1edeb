"""Elastic discs: their compliance, from finite elements or a file, and how far they give way in a stage."""

from cycloid_profile.contact.bodies.elastic_disc.compliance import DiscCompliance as DiscCompliance
from cycloid_profile.contact.bodies.elastic_disc.compliance import read_disc_compliance as read_disc_compliance
from cycloid_profile.contact.bodies.elastic_disc.displacements import kept_compliance as kept_compliance
from cycloid_profile.contact.bodies.elastic_disc.displacements import stage_compliance as stage_compliance
from cycloid_profile.contact.bodies.elastic_disc.displacements import stage_displacements as stage_displacements
from cycloid_profile.contact.bodies.elastic_disc.finite_elements import disc_compliance as disc_compliance
