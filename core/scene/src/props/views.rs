//! Properties of cameras, lights and paths.

use tatu_errors::Refusal;
use tatu_plugin_api::{abi::TATU_ERR_ARGUMENT, safe::Value};

use super::changed::{Changed, refuse};
use crate::{
    object::{Camera, LIGHT_FORMS, Light, LightForm, Path},
    rows::Row,
};

impl Camera {
    pub(crate) fn get(&self, row: Row) -> Option<Value> {
        Some(Value::Float(match row {
            Row::CameraAngle => self.angle,
            Row::CameraOrtho => self.ortho_size,
            Row::CameraNear => self.near,
            Row::CameraFar => self.far,
            _ => return None,
        }))
    }

    pub(crate) fn set(&mut self, row: Row, value: &Value) -> Result<Option<Changed>, Refusal> {
        let Value::Float(x) = *value else { return Ok(None) };
        match row {
            Row::CameraAngle if x > 0.0 && x < std::f64::consts::PI => self.angle = x,
            Row::CameraAngle => return refuse(TATU_ERR_ARGUMENT, "a camera's angle must be above 0 and below pi rad"),
            Row::CameraOrtho if x >= 0.0 => self.ortho_size = x,
            Row::CameraNear if x > 0.0 => self.near = x,
            Row::CameraFar if x > 0.0 => self.far = x,
            Row::CameraOrtho => return refuse(TATU_ERR_ARGUMENT, "the orthographic size must not be negative"),
            Row::CameraNear | Row::CameraFar => {
                return refuse(TATU_ERR_ARGUMENT, "a clipping distance must be greater than 0");
            }
            _ => return Ok(None),
        }
        Ok(Some(Changed::Value))
    }
}

impl Light {
    pub(crate) fn get(&self, row: Row) -> Option<Value> {
        Some(match row {
            Row::LightForm => Value::text(LIGHT_FORMS[self.form as usize]),
            Row::LightOn => Value::Bool(self.on),
            Row::LightColor => Value::Floats(self.color.to_vec()),
            Row::LightAngle => Value::Float(self.angle),
            _ => return None,
        })
    }

    pub(crate) fn set(&mut self, row: Row, value: &Value, text: &str) -> Result<Option<Changed>, Refusal> {
        match (row, value) {
            (Row::LightForm, _) => {
                self.form = match text {
                    "omni" => LightForm::Omni,
                    "spot" => LightForm::Spot,
                    _ => LightForm::Directional,
                }
            }
            (Row::LightOn, Value::Bool(on)) => self.on = *on,
            (Row::LightColor, Value::Floats(v)) => match v.as_slice() {
                [r, g, b] if v.iter().all(|x| (0.0..=1.0).contains(x)) => self.color = [*r, *g, *b],
                _ => return refuse(TATU_ERR_ARGUMENT, "a color must be red, green and blue, each from 0 to 1"),
            },
            (Row::LightAngle, Value::Float(x)) if *x > 0.0 && *x <= std::f64::consts::FRAC_PI_2 => self.angle = *x,
            (Row::LightAngle, _) => {
                return refuse(TATU_ERR_ARGUMENT, "a spotlight's half angle must be above 0 and at most pi / 2 rad");
            }
            _ => return Ok(None),
        }
        Ok(Some(Changed::Value))
    }
}

impl Path {
    pub(crate) fn get(&self, row: Row) -> Option<Value> {
        Some(match row {
            Row::PathPoints => Value::Floats(self.points.clone()),
            Row::PathRounding => Value::Floats(self.rounding.clone()),
            Row::PathClosed => Value::Bool(self.closed),
            _ => return None,
        })
    }

    pub(crate) fn set(&mut self, row: Row, value: &Value) -> Result<Option<Changed>, Refusal> {
        match (row, value) {
            (Row::PathPoints, Value::Floats(v)) if v.len() % 7 == 0 && v.iter().all(|x| x.is_finite()) => {
                self.points.clone_from(v);
            }
            (Row::PathPoints, _) => {
                return refuse(TATU_ERR_ARGUMENT, "a path must have 7 finite numbers for each point");
            }
            (Row::PathRounding, Value::Floats(v)) if v.len() % 3 == 0 && v.iter().all(|x| x.is_finite()) => {
                self.rounding.clone_from(v);
            }
            (Row::PathRounding, _) => {
                return refuse(TATU_ERR_ARGUMENT, "a rounding must have 3 finite numbers for each point");
            }
            (Row::PathClosed, Value::Bool(b)) => self.closed = *b,
            _ => return Ok(None),
        }
        Ok(Some(Changed::Value))
    }
}
