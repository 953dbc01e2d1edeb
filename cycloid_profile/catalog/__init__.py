"""Published drives and article tables, one TOML file each, with source and assumptions."""

from cycloid_profile.catalog.articles import LostMotionArticle as LostMotionArticle
from cycloid_profile.catalog.articles import PublishedPart as PublishedPart
from cycloid_profile.catalog.articles import lost_motion_article as lost_motion_article
from cycloid_profile.catalog.articles import tooth_profile_article as tooth_profile_article
from cycloid_profile.catalog.drives import catalog_drive as catalog_drive
from cycloid_profile.catalog.drives import catalog_names as catalog_names
from cycloid_profile.catalog.drives import catalog_text as catalog_text
