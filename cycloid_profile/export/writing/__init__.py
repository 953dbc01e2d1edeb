"""Exporters and the files they write, complete or not at all, with their manifest."""

from cycloid_profile.export.writing.exporter import Exporter as Exporter
from cycloid_profile.export.writing.exporter import LibraryMissing as LibraryMissing
from cycloid_profile.export.writing.exporter import SingleFileExporter as SingleFileExporter
from cycloid_profile.export.writing.exporter import WrittenFile as WrittenFile
from cycloid_profile.export.writing.exporter import lib3mf as lib3mf
from cycloid_profile.export.writing.exporter import read_back_error as read_back_error
from cycloid_profile.export.writing.exporter import require_cad_kernel as require_cad_kernel
from cycloid_profile.export.writing.folder import PROTECTED as PROTECTED
from cycloid_profile.export.writing.folder import Protection as Protection
from cycloid_profile.export.writing.folder import atomic_folder as atomic_folder
from cycloid_profile.export.writing.folder import written_folders as written_folders
from cycloid_profile.export.writing.manifest import MANIFEST as MANIFEST
from cycloid_profile.export.writing.manifest import manifest_entry as manifest_entry
from cycloid_profile.export.writing.manifest import notes_of as notes_of
from cycloid_profile.export.writing.manifest import read_manifest as read_manifest
from cycloid_profile.export.writing.manifest import unchanged_entries as unchanged_entries
from cycloid_profile.export.writing.manifest import write_manifest as write_manifest
from cycloid_profile.export.writing.names import dxf_text as dxf_text
from cycloid_profile.export.writing.names import plain_name as plain_name
from cycloid_profile.export.writing.names import step_text as step_text
from cycloid_profile.export.writing.signals import STOPPING as STOPPING
from cycloid_profile.export.writing.signals import signals_deferred as signals_deferred
