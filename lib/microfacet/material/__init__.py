"""What happens where light meets a facet: reflection, Fresnel."""
